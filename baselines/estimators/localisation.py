"""Localisation: where am I? Dead reckoning, covariance intersection, or a decentralised EKF.

Smith et al. 2021 (BOIDS), Section 2. `setting` chooses between two readings of the paper:

- `authors`: what produced its figures. Process noise and measurement noise are diagonals of
  standard deviations; home resets the estimate; the filter corrects one robot of two, behind
  gates; flocks align on positions.
- `corrected`: textbook noise, propagated by the Jacobians; home is a private measurement update;
  both robots are corrected; flocks align on velocities; the covariance stimulus has a scale that
  fits such covariances.

Not in the paper, and chosen here: the corrected filters hold a device's constant error for a part
of its noise (the variances add up), for nothing tells them of it.
"""

from typing import Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from baselines.estimators.arena import start_in_arena
from baselines.estimators.base import ESTIMATORS
from baselines.estimators.covariance_intersection import intersect
from baselines.estimators.dead_reckoning import carry_factors, predict, start_again
from baselines.estimators.decentralised_ekf import (
    correct_by_sight,
    correct_each_alone,
    correct_privately,
)
from baselines.estimators.flocking import describe_correction, describe_flock
from swarm_forage_env.arrays import Array, Bool, Float32, Float64
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.scenario import Part, Scenario, record
from swarm_forage_env.waypoints_interface import (
    Correction,
    Sightings,
    WaypointReadings,
    WaypointSituation,
)
from swarm_forage_env.waypoints_scenario import AnyScenario, WaypointsScenario

START_VARIANCE = 0.1
"""Of x, y [m^2] and heading [rad^2] at the start and, for the authors, at home (code)."""

DOUBT_MAX = {"authors": 5.0, "corrected": 0.05}
"""Highest covariance norm allowed: 5 (published), or a hundredth for textbook noise (chosen)."""

DRIFT_MAX = 1.0
"""Highest distance allowed between the estimate and dead reckoning [m] (published)."""

VECTORS = ("goal", "home", "centre", "crowd", "flow", "velocity")
STIMULI = ("density", "doubt", "drift")


@ESTIMATORS.register("localisation")
class LocalisationParameters(Part):
    """Which estimator, and which reading of the paper."""

    worlds: ClassVar[tuple[type[Part], ...]] = (Scenario, WaypointsScenario)

    estimator: Literal[
        "dead_reckoning", "covariance_intersection", "decentralised_ekf", "social_odometry"
    ] = Field(
        "decentralised_ekf",
        description="How a robot finds out where it is; social_odometry where it forages, too"
        " (published)",
    )
    setting: Literal["authors", "corrected"] = Field(
        "corrected",
        description="What made the paper's figures (waypoints only), or textbook filters (chosen)",
    )

    @property
    def speaks(self) -> bool:
        """Whether robots that forage tell each other anything; who reckons alone does not."""
        return self.estimator != "dead_reckoning"

    def start(self, scenario: AnyScenario, n_worlds: int) -> Any:  # noqa: ANN401 of its world
        """The running estimator of a block of worlds."""
        if not isinstance(scenario, WaypointsScenario):
            if self.setting != "corrected":
                raise ConfigError(
                    f"setting='{self.setting}': is of robots that visit waypoints, not of"
                    f" {scenario.name}; leave it out"
                )
            return start_in_arena(self.estimator, scenario, n_worlds)
        if self.estimator == "social_odometry":
            raise ConfigError(
                f"estimator='social_odometry': is for robots that forage, not for {scenario.name};"
                " take dead_reckoning, covariance_intersection or decentralised_ekf"
            )
        return Localisation(self, scenario, n_worlds)


class Localisation:
    """What all robots of a block of worlds believe of their own poses."""

    def __init__(
        self, parameters: LocalisationParameters, scenario: WaypointsScenario, n_worlds: int
    ) -> None:
        """Robots that are about to be told where they are."""
        self.n_robots = n = scenario.task.n_robots
        rows = n_worlds * n
        self.parameters = parameters
        self._authors = parameters.setting == "authors"
        self._tolerance = scenario.task.tolerance
        self._home_variance = scenario.sensors.home_noise**2
        self._numbers = _numbers(parameters, scenario)
        self.reckoned: Float64[Array, "rows 3"] = np.zeros((rows, 3))
        self.reckoned_P: Float64[Array, "rows 3 3"] = np.zeros((rows, 3, 3))
        self.pose: Float64[Array, "rows 3"] = np.zeros((rows, 3))
        self.P: Float64[Array, "rows 3 3"] = np.zeros((rows, 3, 3))
        self.velocity: Float64[Array, "rows 2"] = np.zeros((rows, 2))
        kept = n if parameters.estimator == "decentralised_ekf" else 0
        self.factors: Float64[Array, "rows robots 3 3"] = np.zeros((rows, kept, 3, 3))
        self._no_factors = np.zeros((rows, 0, 3, 3))
        self._room = np.zeros((5, 3, 3))
        self._joint: tuple[Any, Any, Any] = (
            np.zeros((3, 6, 6)), np.zeros((2, 6)), np.zeros((6, 2))
        )  # fmt: skip
        self._fusing = np.zeros((n, 3, 3)), np.zeros((n, 3)), np.zeros(n), np.zeros((2, 3, 3))
        self._heard: Sightings | None = None
        self._compass: Float32[Array, " rows"] = np.zeros(rows, np.float32)
        self.encounter = _no_correction(rows)
        self.situation: WaypointSituation
        self._start(slice(0, rows))

    def observe(
        self, readings: WaypointReadings, heard: Sightings, pull: Float32[Array, "rows 2"]
    ) -> None:
        """Take in one tick: go on by what was measured, look for home, look at each other."""
        if self.parameters.estimator != "dead_reckoning":
            self._predict(readings, self.pose, self.P)
        if self.factors.size and not self._authors:
            dt = float(self._numbers[0]["dt"])
            carry_factors(readings.motion, dt, self.pose, self.factors)
        self._predict(readings, self.reckoned, self.reckoned_P)
        self._look_for_home(readings)
        self._heard, self._compass = heard, readings.compass
        self._describe(readings, heard, pull)

    def merge(self, g: Float32[Array, "rows 1"], heard_p_share: float) -> None:
        """Correct every estimate by all neighbours, to the share g of the correction."""
        seen = self._heard
        kind = self.parameters.estimator
        if seen is None or kind == "dead_reckoning":
            return
        sight = seen.seen, seen.range, seen.bearing
        if kind == "covariance_intersection":
            intersect(
                *sight, self._compass, g, self._numbers,
                self.pose.copy(), self.P.copy(), *self._fusing, self.pose, self.P,
            )  # fmt: skip
        elif self._authors:
            correct_each_alone(
                *sight, self._compass, g, self._numbers, self._room, *self._joint,
                self.pose.copy(), self.P.copy(), self.factors.copy(),
                self.pose, self.P, self.factors,
            )  # fmt: skip
        else:
            correct_by_sight(
                *sight, g, self._numbers, self._room, *self._joint, self.pose, self.P, self.factors
            )

    @property
    def claim(self) -> Bool[Array, " rows"]:
        """Who believes to be at its goal."""
        return self.situation.arrived

    def reset(self, world: int, seed: int) -> None:
        """Forget everything about one world."""
        self._start(slice(world * self.n_robots, (world + 1) * self.n_robots))

    def _start(self, rows: slice) -> None:
        for pose, P in ((self.reckoned, self.reckoned_P), (self.pose, self.P)):
            pose[rows] = 0.0
            P[rows] = START_VARIANCE * np.eye(3)
        self.velocity[rows] = 0.0
        self.factors[rows] = 0.0

    def _predict(
        self, readings: WaypointReadings, pose: Float64[Array, "rows 3"], P: Array
    ) -> None:
        room = self._room[:2]
        velocity = self.velocity if pose is self._moving else np.zeros_like(self.velocity)
        predict(readings.motion, self._numbers, room, pose, P, velocity)

    @property
    def _moving(self) -> Float64[Array, "rows 3"]:
        """The poses whose velocities the flock goes by."""
        return self.reckoned if self.parameters.estimator == "dead_reckoning" else self.pose

    def _look_for_home(self, readings: WaypointReadings) -> None:
        beliefs = [(self.reckoned, self.reckoned_P, self._no_factors)]
        if self.parameters.estimator != "dead_reckoning":
            beliefs.append((self.pose, self.P, self.factors))
        for pose, P, factors in beliefs:
            if self._authors:
                start_again(readings.at_home, readings.fix, START_VARIANCE, pose, P)
            else:
                correct_privately(
                    readings.at_home, readings.fix, self._home_variance, self._room,
                    pose, P, factors,
                )  # fmt: skip
        if self.parameters.estimator == "dead_reckoning":
            self.pose[:], self.P[:] = self.reckoned, self.reckoned_P

    def _describe(
        self, readings: WaypointReadings, heard: Sightings, pull: Float32[Array, "rows 2"]
    ) -> None:
        e, rows = self.encounter, len(self.pose)
        describe_correction(
            heard.seen, heard.range, heard.bearing, self.pose, self.P,
            e.valid, e.neighbours, e.own_doubt, e.heard_doubt, e.disagreement,
        )  # fmt: skip
        vectors = np.empty((rows, len(VECTORS), 2), np.float32)
        stimuli = np.empty((rows, len(STIMULI)), np.float32)
        describe_flock(
            heard.seen, readings.compass, readings.goal, self._numbers,
            self.reckoned, self.pose, self.P, self.velocity, vectors, stimuli,
        )  # fmt: skip
        way = self.pose[:, :2] - readings.goal
        self.situation = WaypointSituation(
            **{name: vectors[:, k] for k, name in enumerate(VECTORS)},
            **{name: stimuli[:, k] for k, name in enumerate(STIMULI)},
            arrived=np.hypot(way[:, 0], way[:, 1]) < self._tolerance,
            pull=pull,
        )


def _numbers(parameters: LocalisationParameters, scenario: WaypointsScenario) -> Array:
    """The scenario's noise and limits as kernels read them."""
    sensors = scenario.sensors
    return record(
        authors=parameters.setting == "authors",
        dt=scenario.tick,
        speed_noise=sensors.speed_noise,
        turn_noise=sensors.turn_noise,
        var_speed=sensors.speed_noise**2 + sensors.speed_bias**2,
        var_turn=sensors.turn_noise**2 + sensors.turn_bias**2,
        range_noise=sensors.range_noise,
        bearing_noise=sensors.bearing_noise,
        reach=sensors.reach,
        max_speed=scenario.robot.max_speed,
        doubt_max=DOUBT_MAX[parameters.setting],
        drift_max=DRIFT_MAX,
    )


def _no_correction(rows: int) -> Correction:
    return Correction(
        valid=np.zeros(rows, np.bool_),
        neighbours=np.zeros(rows, np.float32),
        own_doubt=np.zeros(rows, np.float32),
        heard_doubt=np.zeros(rows, np.float32),
        disagreement=np.zeros(rows, np.float32),
    )
