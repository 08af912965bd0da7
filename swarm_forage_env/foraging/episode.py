"""The episode of robots that forage: what it came to, and how that is measured."""

import math
from dataclasses import dataclass

import numpy as np

from swarm_forage_env.arrays import Array, Bool, Float64, Int64
from swarm_forage_env.episode import EpisodeHeader, EpisodeKind, MeasuredLoop
from swarm_forage_env.foraging import metrics
from swarm_forage_env.raw_control import has_estimators

SAMPLE_EVERY = 1.0
"""Time between two samples of the localisation error [s]."""

SERIES_LENGTH = 100
"""Samples in a series over an episode."""


@dataclass(frozen=True)
class ForagingEpisode(EpisodeHeader):
    """The results of one foraging episode. `foraging.metrics` defines each number."""

    round_trips: int
    """Round trips of all robots."""
    recruitment_time_s: float | None
    """Time until every robot had visited both areas [s]; None if not all did."""
    on_path_share: float
    """Share of the robots on the path, mean over the second half."""
    lost_events: int
    """How often robots found themselves lost."""
    messages: int
    """Messages heard."""
    localisation_error_m: float | None
    """Mean over robots with an estimator, areas they know of, and time [m]; None if nothing was
    ever known, as where policies are everything."""
    wall_s: float
    """Computing time: an equal share of that of the block the episode ran in [s]."""
    on_path_over_time: tuple[float, ...] = ()
    """Share of the robots on the path at the end of each hundredth of the episode."""
    recruited_at_s: tuple[float, ...] = ()
    """When the robots had visited both areas, earliest first; the others are left out [s]."""
    sound_robots: int | None = None
    """Robots without a fault; like all that follows None in a scenario without faults."""
    round_trips_sound: int | None = None
    """Round trips of the sound robots."""
    on_path_share_sound: float | None = None
    """Share of the sound robots on the path, mean over the second half; None if none is sound."""
    lost_events_sound: int | None = None
    """How often sound robots found themselves lost."""
    localisation_error_sound_m: float | None = None
    """Mean over sound robots, areas they know of, and time [m]; None if nothing was ever known."""


class LocalisationErrorMeter:
    """The localisation error of each world, summed over chosen robots, known areas and samples."""

    def __init__(self, is_meant: Bool[Array, "worlds robots"]) -> None:
        self._is_meant = is_meant
        self._sum: Float64[Array, " worlds"] = np.zeros(len(is_meant))
        self._count: Int64[Array, " worlds"] = np.zeros(len(is_meant), np.int64)

    def sample(self, loop: MeasuredLoop) -> None:
        """Compare what is believed now with what is true."""
        world, minds = loop.world, loop.controller.minds
        if has_estimators(minds):
            situations = minds["estimator"]["situation"]
            metrics.add_errors(
                world.robots, situations, world.worlds, self._is_meant, self._sum, self._count
            )

    def mean(self, world: int) -> float | None:
        """Mean error of one world [m]; None if nothing was known at any sample."""
        return float(self._sum[world] / self._count[world]) if self._count[world] else None


class ForagingMeter:
    """All metrics of a block of worlds, which are about to start."""

    def __init__(self, loop: MeasuredLoop) -> None:
        self._loop = loop
        robots, scenario = loop.world.robots, loop.world.scenario
        self._error = LocalisationErrorMeter(np.ones(robots.shape, np.bool_))
        self._is_sound: Bool[Array, "worlds robots"] = metrics.is_sound(loop.world.faults["kinds"])
        self._sound_error = LocalisationErrorMeter(self._is_sound)
        self._has_faults: Bool[Array, " worlds"] = loop.world.worlds["has_faults"] != 0
        self._on_path: list[Float64[Array, " worlds"]] = []
        self._n_ticks: int = scenario.n_ticks
        self._period: int = max(1, round(SAMPLE_EVERY / scenario.tick))

    def _hundredths(self, tick: int) -> int:
        """How many hundredths of the episode are over with a tick."""
        return tick * SERIES_LENGTH // self._n_ticks

    def next_sample(self, tick: int) -> int:
        """The next tick after this one with which a period or a hundredth of the episode ends."""
        next_share = -(-(self._hundredths(tick) + 1) * self._n_ticks // SERIES_LENGTH)
        return min((tick // self._period + 1) * self._period, next_share)

    def sample(self, tick: int) -> None:
        """Measure what is over with this tick; a short episode has a share on the path a tick."""
        if tick % self._period == 0:
            self._error.sample(self._loop)
            if self._has_faults.any():
                self._sound_error.sample(self._loop)
        if self._hundredths(tick) > self._hundredths(tick - 1):
            world = self._loop.world
            self._on_path.append(metrics.knows_both_areas_now(world.state.known, world.n_worlds))

    def results(self) -> list[dict[str, object]]:
        """The metrics of each world."""
        world, tick = self._loop.world, self._loop.world.scenario.tick
        first_visit, n = world.robots["first_visit"], world.n_worlds
        recruited = metrics.recruitment_time(world.state.first_visit, n, tick)
        messages = metrics.total(world.state.messages, n)
        return [
            {
                **_counts(world.robots[w], self._n_ticks),
                "recruitment_time_s": float(recruited[w]) if math.isfinite(recruited[w]) else None,
                "messages": int(messages[w]),
                "localisation_error_m": self._error.mean(w),
                "on_path_over_time": tuple(float(shares[w]) for shares in self._on_path),
                "recruited_at_s": tuple(metrics.recruited_at(first_visit[w], tick).tolist()),
                **(self._results_of_sound(w) if self._has_faults[w] else {}),
            }
            for w in range(n)
        ]

    def _results_of_sound(self, w: int) -> dict[str, object]:
        world = self._loop.world
        sound, n_ticks = world.robots[w][self._is_sound[w]], world.scenarios[w].n_ticks
        counts = {f"{name}_sound": each for name, each in _counts(sound, n_ticks).items()}
        error = self._sound_error.mean(w)
        return {"sound_robots": len(sound), **counts, "localisation_error_sound_m": error}


def _counts(robots: Array, n_ticks: int) -> dict[str, object]:
    on_path = None
    if len(robots):
        on_path = float(metrics.knows_both_areas_share(robots["path_ticks"], 1, n_ticks)[0])
    return {
        "round_trips": int(robots["round_trips"].sum()),
        "on_path_share": on_path,
        "lost_events": int(robots["lost_events"].sum()),
    }


FORAGING_EPISODE = EpisodeKind(
    ForagingEpisode,
    ForagingMeter,
    "round_trips",
    "Round trips",
    {
        "round_trips": ("round\ntrips", 1.0),
        "recruitment_time_s": ("recruit-\nment [s]", 1.0),
        "on_path_share": ("on path\n[%]", 100.0),
        "lost_events": ("lost\nevents", 1.0),
        "messages": ("messages\n[1000]", 0.001),
        "localisation_error_m": ("location\nerror [cm]", 100.0),
        "round_trips_sound": ("trips,\nsound", 1.0),
        "on_path_share_sound": ("on path,\nsound [%]", 100.0),
        "lost_events_sound": ("lost,\nsound", 1.0),
        "localisation_error_sound_m": ("error,\nsound [cm]", 100.0),
    },
    sometimes_words="Of the robots without a fault",
)
