"""One waypoint episode: run a swarm from reset to the end, and measure it."""

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from baselines.controller import Recipe
from baselines.estimators.matrices import spectral_norm3
from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.compiler import kernel
from swarm_forage_env.loop import WaypointsLoop
from swarm_forage_env.waypoints_scenario import WaypointsScenario


@dataclass(frozen=True)
class WaypointEpisode:
    """The results of one waypoint episode."""

    scenario: str
    """Name of the scenario."""

    controller: str
    """The controller as it was asked for: `boids-goal:estimator=dead_reckoning`."""

    seed: int
    """Seed of the world; controllers under one seed meet the same world."""

    physics: str
    """Engine that moved the robots."""

    n_robots: int
    """Robots."""

    duration_s: float
    """Length of the episode [s]."""

    covariance_norm: float
    """Spectral norm of the covariance, mean over robots and time."""

    position_error_m: float
    """Distance between estimated and true position, mean over robots and time [m]."""

    largest_error_m: float
    """The same, of the worst robot at the worst time [m]."""

    goals_per_robot: float
    """Goals claimed and truly reached."""

    false_goals_per_robot: float
    """Goals claimed and not reached."""

    success_rate: float | None
    """Share of the claims that were right [0 to 1]; None if there were none."""

    wall_s: float
    """Computing time: an equal share of that of the block the episode ran in [s]."""


class WaypointErrorMeter:
    """Covariance norm and position error of each world, summed over robots and time."""

    def __init__(self, n_worlds: int) -> None:
        """Start all sums at zero."""
        self.sums: Float64[Array, "worlds 2"] = np.zeros((n_worlds, 2))
        self.largest: Float64[Array, " worlds"] = np.zeros(n_worlds)

    def sample(self, loop: WaypointsLoop) -> None:
        """Add the covariance norms and the position errors of this tick."""
        estimator: Any = loop.controller.estimator
        accumulate(
            estimator.P, estimator.pose, loop.world.state.pose, loop.world.n_robots,
            self.sums, self.largest,
        )  # fmt: skip


@kernel
def accumulate(
    covariance: Float64[Array, "rows 3 3"],
    believed: Float64[Array, "rows 3"],
    pose: Float64[Array, "rows 3"],
    n_robots: int,
    sums: Float64[Array, "worlds 2"],
    largest: Float64[Array, " worlds"],
) -> None:
    """Add the norms and errors of one tick, in place.

    Source: BOIDS, Section 5, for the metric.
    """
    for i in range(pose.shape[0]):
        world = i // n_robots
        error = np.hypot(believed[i, 0] - pose[i, 0], believed[i, 1] - pose[i, 1])
        sums[world, 0] += spectral_norm3(covariance[i])
        sums[world, 1] += error
        largest[world] = max(largest[world], error)


def run_waypoint_episodes(
    scenario: WaypointsScenario, recipe: Recipe, seeds: Sequence[int], physics: str
) -> list[WaypointEpisode]:
    """Run one waypoint episode for each seed, side by side; each is the same when run alone."""
    start = time.perf_counter()
    loop = WaypointsLoop(scenario, recipe, seeds, physics)
    meter = WaypointErrorMeter(len(seeds))
    for _ in range(scenario.n_ticks):
        loop.step()
        meter.sample(loop)
    estimator: Any = loop.controller.estimator
    loop.world.judge(estimator.claim)
    wall = (time.perf_counter() - start) / len(seeds)
    n, state = scenario.task.n_robots, loop.world.state
    right = state.right.reshape(len(seeds), n).sum(axis=1)
    wrong = state.wrong.reshape(len(seeds), n).sum(axis=1)
    samples = n * (scenario.n_ticks + scenario.task.extra_ticks)
    return [
        WaypointEpisode(
            scenario=scenario.name,
            controller=recipe.name,
            seed=seed,
            physics=physics,
            n_robots=n,
            duration_s=scenario.n_ticks * scenario.tick,
            covariance_norm=float(meter.sums[world, 0] / samples),
            position_error_m=float(meter.sums[world, 1] / samples),
            largest_error_m=float(meter.largest[world]),
            goals_per_robot=float(right[world] / n),
            false_goals_per_robot=float(wrong[world] / n),
            success_rate=_share(int(right[world]), int(wrong[world])),
            wall_s=wall,
        )
        for world, seed in enumerate(seeds)
    ]


def _share(right: int, wrong: int) -> float | None:
    return right / (right + wrong) if right + wrong else None
