"""The episode of robots that forage: what it came to, and how that is measured."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.episode import EpisodeKind
from swarm_forage_env.foraging.metrics import (
    believed_places,
    knows_both_areas_now,
    knows_both_areas_share,
    localisation_error,
    nearest_areas,
    recruited_at,
    recruitment_time,
    total,
)

SAMPLE_EVERY = 1.0
"""Time between two samples of the localisation error [s]."""

SERIES_LENGTH = 100
"""Samples in a series over an episode."""


@dataclass(frozen=True)
class ForagingEpisode:
    """The results of one foraging episode. `foraging.metrics` defines each number."""

    scenario: str
    """Name of the scenario."""

    controller: str
    """The controller as it was asked for: `ssgiff`, or `ssgiff:beta=0.02`."""

    seed: int
    """Seed of the world; controllers under one seed meet the same world."""

    physics: str
    """Engine that moved the robots."""

    n_robots: int
    """Robots."""

    duration_s: float
    """Length of the episode [s]."""

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
    """Mean over robots, areas they know of, and time [m]; None if nothing was ever known."""

    wall_s: float
    """Computing time: an equal share of that of the block the episode ran in [s]."""

    on_path_over_time: tuple[float, ...] = ()
    """Share of the robots on the path at the end of each hundredth of the episode."""

    recruited_at_s: tuple[float, ...] = ()
    """When the robots had visited both areas, earliest first; the others are left out [s]."""


class LocalisationErrorMeter:
    """The localisation error of each world, summed over robots, known areas and samples."""

    def __init__(self, n_worlds: int) -> None:
        """Nothing measured yet."""
        self._sum: Float64[Array, " worlds"] = np.zeros(n_worlds)
        self._count: Float64[Array, " worlds"] = np.zeros(n_worlds)

    def sample(self, loop: Any) -> None:  # noqa: ANN401 a control loop
        """Compare what is believed now with what is true."""
        world, situation = loop.world, loop.situation
        pose, known = world.state.pose, situation.known
        areas = nearest_areas(world.worlds, believed_places(pose, situation.areas, known))
        error = localisation_error(pose, situation.areas, known, areas)
        self._sum += error.reshape(len(self._sum), -1).sum(axis=1)
        self._count += situation.known.reshape(len(self._sum), -1).sum(axis=1)

    def mean(self, world: int) -> float | None:
        """Mean error of one world [m]; None if nothing was known at any sample."""
        return float(self._sum[world] / self._count[world]) if self._count[world] else None


class OnPathMeter:
    """The share of the robots on the path in each world, sampled evenly over the episode."""

    def __init__(self, n_ticks: int) -> None:
        """Nothing sampled yet; an episode shorter than the series has a sample a tick."""
        self._n_ticks = n_ticks
        self._samples: list[Float64[Array, " worlds"]] = []

    def sample(self, loop: Any, tick: int) -> None:  # noqa: ANN401 a control loop
        """Take a sample if a hundredth of the episode ends with this tick."""
        if tick * SERIES_LENGTH // self._n_ticks > (tick - 1) * SERIES_LENGTH // self._n_ticks:
            world = loop.world
            self._samples.append(knows_both_areas_now(world.state.known, world.n_worlds))

    def series(self, world: int) -> tuple[float, ...]:
        """The samples of one world."""
        return tuple(float(sample[world]) for sample in self._samples)


class ForagingMeter:
    """All metrics of a block of worlds."""

    def __init__(self, loop: Any) -> None:  # noqa: ANN401 a control loop
        """Of a loop whose worlds are about to start."""
        self._loop = loop
        scenario = loop.world.scenario
        self._error = LocalisationErrorMeter(loop.world.n_worlds)
        self._path = OnPathMeter(scenario.n_ticks)
        self._period = max(1, round(SAMPLE_EVERY / scenario.tick))

    def sample(self, tick: int) -> None:
        """Measure what is over with this tick."""
        if tick % self._period == 0:
            self._error.sample(self._loop)
        self._path.sample(self._loop, tick)

    def results(self) -> list[dict[str, Any]]:
        """The metrics of each world."""
        world, tick = self._loop.world, self._loop.world.scenario.tick
        state, n, first_visit = world.state, world.n_worlds, world.robots["first_visit"]
        recruited = recruitment_time(state.first_visit, n, tick)
        on_path = knows_both_areas_share(state.path_ticks, n, world.scenario.n_ticks)
        trips, lost = total(state.round_trips, n), total(state.lost_events, n)
        messages = total(state.messages, n)
        return [
            {
                "round_trips": int(trips[w]),
                "recruitment_time_s": float(recruited[w]) if math.isfinite(recruited[w]) else None,
                "on_path_share": float(on_path[w]),
                "lost_events": int(lost[w]),
                "messages": int(messages[w]),
                "localisation_error_m": self._error.mean(w),
                "on_path_over_time": self._path.series(w),
                "recruited_at_s": tuple(recruited_at(first_visit[w], tick).tolist()),
            }
            for w in range(n)
        ]


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
    },
    series=("on_path_over_time", "recruited_at_s"),
)
