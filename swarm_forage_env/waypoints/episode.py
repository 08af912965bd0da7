"""The episode of robots that visit waypoints: what it came to, and how that is measured."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.episode import EpisodeHeader, EpisodeKind, MeasuredLoop
from swarm_forage_env.no_layers import has_estimators


@dataclass(frozen=True)
class WaypointEpisode(EpisodeHeader):
    """The results of one waypoint episode."""

    covariance_norm: float | None
    """Spectral norm of the covariance, mean over robots and time; like both errors None where
    policies are everything, so that no robot has an estimate."""

    position_error_m: float | None
    """Distance between estimated and true position, mean over robots and time [m]."""

    largest_error_m: float | None
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
    """Covariance norm and position error of each world, summed over robots and time.

    Source: BOIDS, Section 5, for the metric.
    """

    def __init__(self, n_worlds: int) -> None:
        """Nothing measured yet."""
        self.norms: Float64[Array, " worlds"] = np.zeros(n_worlds)
        self.errors: Float64[Array, " worlds"] = np.zeros(n_worlds)
        self.largest: Float64[Array, " worlds"] = np.zeros(n_worlds)

    def sample(self, loop: MeasuredLoop) -> None:
        """Compare what is believed now with what is true."""
        estimator = loop.controller.minds["estimator"]
        away = estimator["belief"]["pose"] - loop.world.robots["pose"]
        error = np.hypot(away[:, :, 0], away[:, :, 1])
        self.norms += estimator["covariance_norm"].sum(axis=1)
        self.errors += error.sum(axis=1)
        np.maximum(self.largest, error.max(axis=1), out=self.largest)


class WaypointMeter:
    """All metrics of a block of worlds."""

    def __init__(self, loop: MeasuredLoop) -> None:
        """Of a loop whose worlds are about to start."""
        self._loop = loop
        is_measured = has_estimators(loop.controller.minds)
        self._error = WaypointErrorMeter(loop.world.n_worlds) if is_measured else None

    def next_sample(self, tick: int) -> int:
        """Every tick is measured."""
        return tick + 1

    def sample(self, tick: int) -> None:
        """Measure every tick."""
        if self._error is not None:
            self._error.sample(self._loop)

    def results(self) -> list[dict[str, Any]]:
        """The metrics of each world, the claims of the last tick included.

        An estimator claims after a tick what is judged in the next; a policy of everything claims
        just before the tick that judges it.
        """
        world = self._loop.world
        if self._error is not None:
            world.judge(self._loop.situation.has_arrived > 0.0)
        n = world.n_robots
        right, wrong = world.robots["right"].sum(axis=1), world.robots["wrong"].sum(axis=1)
        return [
            {
                **self._errors(w),
                "goals_per_robot": float(right[w] / n),
                "false_goals_per_robot": float(wrong[w] / n),
                "success_rate": _share(int(right[w]), int(wrong[w])),
            }
            for w in range(world.n_worlds)
        ]

    def _errors(self, which: int) -> dict[str, float | None]:
        """The metrics of what the robots of one world believed."""
        error, world = self._error, self._loop.world
        if error is None:
            return dict.fromkeys(("covariance_norm", "position_error_m", "largest_error_m"))
        samples = world.n_robots * (world.scenario.n_ticks + world.scenario.task.extra_ticks)
        return {
            "covariance_norm": float(error.norms[which] / samples),
            "position_error_m": float(error.errors[which] / samples),
            "largest_error_m": float(error.largest[which]),
        }


def _share(right: int, wrong: int) -> float | None:
    return right / (right + wrong) if right + wrong else None


WAYPOINT_EPISODE = EpisodeKind(
    WaypointEpisode,
    WaypointMeter,
    "goals_per_robot",
    "Goals per robot",
    {
        "goals_per_robot": ("goals a\nrobot", 1.0),
        "false_goals_per_robot": ("false\ngoals", 1.0),
        "success_rate": ("success\n[%]", 100.0),
        "position_error_m": ("position\nerror [cm]", 100.0),
        "covariance_norm": ("covari-\nance", 1.0),
    },
)
