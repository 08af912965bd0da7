"""One foraging episode: run a swarm from reset to the end, and measure it."""

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from baselines.controller import Recipe
from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.loop import ControlLoop
from swarm_forage_env.metrics import (
    localisation_error,
    on_path_now,
    on_path_share,
    recruited_at,
    recruitment_time,
    total,
)
from swarm_forage_env.scenario import Scenario

SAMPLE_EVERY = 1.0
"""Time between two samples of the localisation error [s]."""

SERIES_LENGTH = 100
"""Samples in a series over an episode."""

SERIES = ("on_path_over_time", "recruited_at_s")
"""Fields of an episode that are lists."""


@dataclass(frozen=True)
class Episode:
    """The results of one foraging episode. `swarm_forage_env.metrics` defines each number."""

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
    """Localisation error of each world, summed over robots, known areas and samples."""

    def __init__(self, n_worlds: int) -> None:
        """Start all sums at zero."""
        self._sum: Float64[Array, " worlds"] = np.zeros(n_worlds)
        self._count: Float64[Array, " worlds"] = np.zeros(n_worlds)

    def sample(self, loop: ControlLoop) -> None:
        """Add the distances between estimated and true areas at this tick."""
        world, situation = loop.world, loop.controller.estimator.situation
        error = localisation_error(world.state.pose, situation.areas, situation.known, world.areas)
        self._sum += error.reshape(len(self._sum), -1).sum(axis=1)
        self._count += situation.known.reshape(len(self._sum), -1).sum(axis=1)

    def mean(self, world: int) -> float | None:
        """Mean error of one world [m]; None if no robot knew an area at any sample."""
        return float(self._sum[world] / self._count[world]) if self._count[world] else None


class OnPathMeter:
    """Share of the robots on the path in each world, sampled evenly over the episode."""

    def __init__(self, n_ticks: int) -> None:
        """Start without samples; an episode shorter than the series has one for each tick."""
        self._n_ticks = n_ticks
        self._samples: list[Float64[Array, " worlds"]] = []

    def sample(self, loop: ControlLoop, tick: int) -> None:
        """Take a sample if a hundredth of the episode ends with this tick."""
        if tick * SERIES_LENGTH // self._n_ticks > (tick - 1) * SERIES_LENGTH // self._n_ticks:
            world = loop.world
            self._samples.append(on_path_now(world.state.known, world.n_worlds))

    def series(self, world: int) -> tuple[float, ...]:
        """The samples of one world, in the order of time."""
        return tuple(float(sample[world]) for sample in self._samples)


def run_episodes(
    scenario: Scenario, recipe: Recipe, seeds: Sequence[int], physics: str = "rigid"
) -> list[Episode]:
    """Run one foraging episode for each seed, side by side; each is the same when run alone."""
    start = time.perf_counter()
    loop = ControlLoop(scenario, recipe, seeds, physics)
    meter, path = LocalisationErrorMeter(len(seeds)), OnPathMeter(scenario.n_ticks)
    period = max(1, round(SAMPLE_EVERY / scenario.tick))
    for tick in range(1, scenario.n_ticks + 1):
        loop.step()
        if tick % period == 0:
            meter.sample(loop)
        path.sample(loop, tick)
    wall = (time.perf_counter() - start) / len(seeds)
    episodes = _judge(loop, recipe, seeds, physics, wall)
    return [
        replace(
            episode,
            localisation_error_m=meter.mean(world),
            on_path_over_time=path.series(world),
            recruited_at_s=_recruited(loop, world),
        )
        for world, episode in enumerate(episodes)
    ]


def _judge(
    loop: ControlLoop,
    recipe: Recipe,
    seeds: Sequence[int],
    physics: str,
    wall: float,
) -> list[Episode]:
    """The episodes of a finished block of worlds, from its final state."""
    scenario, state, worlds = loop.world.scenario, loop.world.state, len(seeds)
    recruited = recruitment_time(state.first_visit, worlds, scenario.tick)
    on_path = on_path_share(state.path_ticks, worlds, scenario.n_ticks)
    trips = total(state.round_trips, worlds)
    lost = total(state.lost_events, worlds)
    messages = total(state.messages, worlds)
    return [
        Episode(
            scenario=scenario.name,
            controller=recipe.name,
            seed=seed,
            physics=physics,
            n_robots=scenario.task.n_robots,
            duration_s=scenario.n_ticks * scenario.tick,
            round_trips=int(trips[world]),
            recruitment_time_s=float(recruited[world]) if math.isfinite(recruited[world]) else None,
            on_path_share=float(on_path[world]),
            lost_events=int(lost[world]),
            messages=int(messages[world]),
            localisation_error_m=None,
            wall_s=wall,
        )
        for world, seed in enumerate(seeds)
    ]


def _recruited(loop: ControlLoop, world: int) -> tuple[float, ...]:
    """When the robots of one world had visited both areas [s]."""
    robots = loop.world.n_robots
    first_visit = loop.world.state.first_visit[world * robots : (world + 1) * robots]
    return tuple(recruited_at(first_visit, loop.world.scenario.tick).tolist())
