"""Episodes of foraging: their results, and how these are measured."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from swarm_forage_env.arrays import Array, Bool, Int32
from swarm_forage_env.episode import EpisodeHeader, EpisodeKind, MeasuredLoop
from swarm_forage_env.foraging import metrics

SAMPLE_EVERY = 1.0
"""Time between two samples of the localisation error [s]."""

SERIES_LENGTH = 100
"""Number of samples in a series over an episode."""


@dataclass(frozen=True)
class ForagingEpisode(EpisodeHeader):
    """Results of one foraging episode; `foraging.metrics` defines times, shares and errors."""

    round_trips: int
    """Trips nest -> prey -> nest of all robots, counted when the true position of the middle ground
    sensor is over the nest again (TR 6.1.2)."""
    recruitment_time_s: float | None
    """Time until every robot had visited both areas [s]; None if not all did."""
    on_path_share: float
    """Share of the robots on the path, mean over the second half."""
    lost_events: int
    """Number of times that a controller reported resetting the estimates of a robot (TR 5.1)."""
    messages: int
    """Number of messages received; a message counts once for each receiver."""
    localisation_error_m: float | None
    """Mean over robots with an estimator, areas they know, and time [m]; None if none was ever
    known, as with `learn="everything"`."""
    wall_s: float
    """Computing time of the episode: an equal share of that of its block [s]."""
    on_path_over_time: tuple[float, ...] = ()
    """Share of the robots on the path at the end of each hundredth of the episode."""
    recruited_at_s: tuple[float, ...] = ()
    """Times at which robots had visited both areas, earliest first; without other robots [s]."""
    sound_robots: int | None = None
    """Number of robots without a fault; this and all later fields are None without faults."""
    round_trips_sound: int | None = None
    """Round trips of the sound robots."""
    on_path_share_sound: float | None = None
    """Share of the sound robots on the path, mean over the second half; None if none is sound."""
    lost_events_sound: int | None = None
    """Number of times that sound robots got lost."""
    localisation_error_sound_m: float | None = None
    """Mean over sound robots, areas they know, and time [m]; None if none was ever known."""


class LocalisationErrorMeter:
    """Localisation error of each world, over chosen robots, known areas and samples."""

    def __init__(self, loop: MeasuredLoop, is_meant: Bool[Array, "worlds robots"]) -> None:
        self._loop, n_worlds = loop, len(is_meant)
        sums = np.zeros(n_worlds), np.zeros(n_worlds, np.int64)
        self._is_counted, *self._sums = map(loop.memory.to_device, (is_meant, *sums))
        self._add = loop.kernel(metrics.add_errors, {})

    def sample(self) -> None:
        """Add the current localisation errors to the sums."""
        at, estimators = self._loop.arrays, self._loop.estimators
        if estimators is not None:
            self._add(at["robots"], estimators, at["worlds"], self._is_counted, *self._sums)

    def means(self) -> list[float | None]:
        """Return the mean error of each world [m]; None if no area was known at any sample."""
        sums, counts = (self._loop.memory.read(each).tolist() for each in self._sums)
        return [each / n if n else None for each, n in zip(sums, counts, strict=True)]


class ForagingMeter:
    """Meter of all metrics of a block of worlds, made before their episodes start."""

    def __init__(self, loop: MeasuredLoop) -> None:
        self._loop, scenario, shape = loop, loop.world.scenario, loop.world.robots.shape
        self._errors = [LocalisationErrorMeter(loop, np.ones(shape, np.bool_))]
        self._faulty = np.flatnonzero(loop.world.worlds["has_faults"]).tolist()
        """Worlds with faults."""
        if self._faulty:
            faults = loop.download().world.faults
            self._is_sound: Bool[Array, "worlds robots"] = ~faults["kinds"].any(axis=-1)
            self._errors.append(LocalisationErrorMeter(loop, self._is_sound))
        self._count_on_path = loop.kernel(metrics.count_on_path, {})
        zeros: Int32[Array, "worlds moments"] = np.zeros((shape[0], SERIES_LENGTH), np.int32)
        self._on_path, self._n_shares = loop.memory.to_device(zeros), 0
        self._n_ticks: int = scenario.n_ticks
        self._period: int = max(1, round(SAMPLE_EVERY / scenario.tick))

    def _hundredths(self, tick: int) -> int:
        """Return the number of hundredths of the episode that are over with a tick."""
        return tick * SERIES_LENGTH // self._n_ticks

    def next_sample(self, tick: int) -> int:
        """Return the next tick at which a period or a hundredth of the episode ends."""
        next_share = -(-(self._hundredths(tick) + 1) * self._n_ticks // SERIES_LENGTH)
        return min((tick // self._period + 1) * self._period, next_share)

    def sample(self, tick: int) -> None:
        """Take the samples due at this tick; short episodes have a share on the path per tick."""
        if tick % self._period == 0:
            for each in self._errors:
                each.sample()
        if self._hundredths(tick) > self._hundredths(tick - 1):
            self._count_on_path(self._loop.arrays["robots"], self._n_shares, self._on_path)
            self._n_shares += 1

    def results(self) -> list[dict[str, object]]:
        """Return the metrics of each world."""
        world, tick = self._loop.download().world, self._loop.world.scenario.tick
        recruited = metrics.recruited_at(world.robots["first_visit"], tick)
        on_path = self._loop.memory.read(self._on_path)[:, : self._n_shares] / world.n_robots
        errors = [each.means() for each in self._errors]
        columns = {
            **_counts(world.robots, self._n_ticks),
            "recruitment_time_s": [
                each[-1] if len(each) == world.n_robots else None for each in recruited
            ],
            "messages": world.robots["messages"].sum(axis=1, dtype=np.int64).tolist(),
            "localisation_error_m": errors[0],
            "on_path_over_time": map(tuple, on_path.tolist()),
            "recruited_at_s": recruited,
        }
        results = [
            dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)
        ]
        for w in self._faulty:
            results[w] |= self._of_sound(world.robots[w], self._is_sound[w], errors[-1][w])
        return results

    def _of_sound(
        self, robots: Array, is_sound: Bool[Array, " robots"], error: float | None
    ) -> dict[str, object]:
        sound = robots[None, is_sound]
        counts: dict[str, object] = {
            f"{name}_sound": each if sound.size else None
            for name, (each,) in _counts(sound, self._n_ticks).items()
        }
        return {"sound_robots": sound.size, **counts, "localisation_error_sound_m": error}


def _counts(robots: Array, n_ticks: int) -> dict[str, list[Any]]:
    """Return counts and shares, one value for each world; None for the shares without robots."""
    n_worlds, path_ticks = len(robots), robots["path_ticks"].reshape(-1)
    shares: list[Any] = [None] * n_worlds
    if robots.size:
        shares = metrics.knows_both_areas_share(path_ticks, n_worlds, n_ticks).tolist()
    return {
        "round_trips": robots["round_trips"].sum(axis=1).tolist(),
        "on_path_share": shares,
        "lost_events": robots["lost_events"].sum(axis=1).tolist(),
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
        "sound_robots": ("sound\nrobots", 1.0),
        "round_trips_sound": ("trips,\nsound", 1.0),
        "on_path_share_sound": ("on path,\nsound [%]", 100.0),
        "lost_events_sound": ("lost,\nsound", 1.0),
        "localisation_error_sound_m": ("error,\nsound [cm]", 100.0),
    },
    sometimes_words="Of the robots without a fault",
)
