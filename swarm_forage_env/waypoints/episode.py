"""The results of a waypoints episode, and the meter that measures them."""

from dataclasses import dataclass

import numpy as np

from swarm_forage_env.episode import EpisodeHeader, EpisodeKind, MeasuredLoop
from swarm_forage_env.raw_control import has_estimators


@dataclass(frozen=True)
class WaypointEpisode(EpisodeHeader):
    """The results of one waypoints episode."""

    covariance_norm: float | None
    """Spectral norm of the covariance, mean over robots and time. Like both errors, None if there
    are no estimators, since a policy replaces the whole controller."""
    position_error_m: float | None
    """Distance between estimated and true position, mean over robots and time [m]."""
    largest_error_m: float | None
    """Largest position error of any robot at any time [m]."""
    goals_per_robot: float
    """Goals claimed and reached, per robot."""
    false_goals_per_robot: float
    """Goals claimed but not reached, per robot."""
    success_rate: float | None
    """Share of correct claims [0 to 1]; None without claims."""
    wall_s: float
    """Computing time of the block, divided by its number of episodes [s]."""


class WaypointMeter:
    """Meter of covariance norms, position errors and claims in the worlds of a loop.

    Source: BOIDS, Section IV; Eq. 40, for the mean norm.
    """

    def __init__(self, loop: MeasuredLoop) -> None:
        self._loop = loop.download()
        self._has_estimators = has_estimators(self._loop.controller.minds)
        self._norms, self._errors, self._largest = np.zeros((3, loop.world.n_worlds))

    def next_sample(self, tick: int) -> int:
        """Return the next tick: every tick is measured."""
        return tick + 1

    def sample(self, tick: int) -> None:
        """Add the current covariance norms and position errors."""
        if self._has_estimators:
            estimator = self._loop.controller.minds["estimator"]
            away = estimator["belief"]["pose"] - self._loop.world.robots["pose"]
            error = np.hypot(away[:, :, 0], away[:, :, 1])
            self._norms += estimator["covariance_norm"].sum(axis=1)
            self._errors += error.sum(axis=1)
            np.maximum(self._largest, error.max(axis=1), out=self._largest)

    def results(self) -> list[dict[str, object]]:
        """Return the metrics of each world, including the claims of the last tick.

        The claims of an estimator are judged in the next tick; those of a policy that replaces the
        whole controller are made just before the tick that judges them.
        """
        world, n = self._loop.world, self._loop.world.n_robots
        if self._has_estimators:
            world.judge(self._loop.situation.has_arrived > 0.0)
        samples = n * (world.scenario.n_ticks + world.scenario.task.extra_ticks)
        means = np.stack([self._norms / samples, self._errors / samples, self._largest], axis=1)
        errors = means.tolist() if self._has_estimators else [[None] * 3] * world.n_worlds
        claims = np.stack([world.robots["right"].sum(axis=1), world.robots["wrong"].sum(axis=1)])
        return [
            {
                **dict(zip(ERRORS, of_world, strict=True)),
                "goals_per_robot": right / n,
                "false_goals_per_robot": wrong / n,
                "success_rate": right / (right + wrong) if right + wrong else None,
            }
            for of_world, (right, wrong) in zip(errors, claims.T.tolist(), strict=True)
        ]


ERRORS = ("covariance_norm", "position_error_m", "largest_error_m")
"""Metrics of the estimates; None without estimators."""

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
