"""Boids: alignment, separation, cohesion, home and goal, with fixed or adaptive gains.

Smith et al. 2021 (BOIDS), Sections 3 and 4.

Not in the paper, and as the authors' code has it: every rule seeks its direction from the
present velocity (`seek`); the sum is a pull at full strength; a robot that has just claimed its
goal goes by the other rules until it has a new one; gains are not clamped, so that they turn
negative where a stimulus exceeds its allowed value.
"""

from collections.abc import Sequence
from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from baselines.motion.base import MOTIONS
from baselines.motion.boids_arena import ArenaBoids
from baselines.motion.flock import flock
from swarm_forage_env.arrays import Array, Float32, Float64
from swarm_forage_env.scenario import NotNegative, Part, Positive, Scenario, record
from swarm_forage_env.waypoints_interface import WaypointSituation
from swarm_forage_env.waypoints_scenario import AnyScenario, WaypointsScenario


@MOTIONS.register("boids")
class BoidsParameters(Part):
    """How the gains come about, and the fixed ones."""

    worlds: ClassVar[tuple[type[Part], ...]] = (Scenario, WaypointsScenario)

    gains: Literal["goal", "static", "adaptive"] = Field(
        "adaptive", description="Goal alone, the fixed gains below, or those of Eq. 33-37"
    )
    alignment: NotNegative = Field(
        1.0, description="K_a of static gains. BOIDS, authors' code (code)"
    )
    separation: NotNegative = Field(
        1.0, description="K_s of static gains. BOIDS, authors' code (code)"
    )
    cohesion: NotNegative = Field(
        1.0, description="K_c of static gains. BOIDS, authors' code (code)"
    )
    homing: NotNegative = Field(1.0, description="K_h of static gains. BOIDS, authors' code (code)")
    seeking: NotNegative = Field(
        1.0, description="K_g of static gains. BOIDS, authors' code (code)"
    )

    @property
    def fixed(self) -> tuple[float, float, float, float, float]:
        """The gains of the rules where they do not adapt."""
        if self.gains == "goal":
            return 0.0, 0.0, 0.0, 0.0, 1.0
        return self.alignment, self.separation, self.cohesion, self.homing, self.seeking

    trust: Positive = Field(
        10.0,
        description="Where robots forage, p of the goal at which nothing is trusted any more: a"
        " path [m], or of the covariance filters a standard deviation [m] (chosen)",
    )

    def start(self, scenario: AnyScenario, seeds: Sequence[int]) -> "Boids | ArenaBoids":
        """The running motion of a block of worlds, one for each seed."""
        if isinstance(scenario, WaypointsScenario):
            return Boids(self, scenario)
        adaptive = self.gains == "adaptive"
        return ArenaBoids(self.fixed, adaptive, self.trust, scenario, seeds)


class Boids:
    """The motion of all robots of a block of waypoints worlds."""

    def __init__(self, parameters: BoidsParameters, scenario: WaypointsScenario) -> None:
        """Robots of a scenario."""
        self._fixed: Float64[Array, 5] = np.array(parameters.fixed)
        self._gains: Float64[Array, 5] = np.zeros(5)
        self._numbers = record(
            adaptive=parameters.gains == "adaptive",
            side=scenario.task.side,
            max_speed=scenario.robot.max_speed,
        )

    def __call__(self, situation: WaypointSituation) -> Float32[Array, "rows 2"]:
        """The pull on every robot, in its body frame."""
        s = situation
        pull = np.empty(s.goal.shape, np.float32)
        ways = np.stack([s.flow, s.crowd, s.centre, s.home, s.goal], axis=1)
        stimuli = np.stack([s.density, s.doubt, s.drift], axis=1)
        velocity = np.ascontiguousarray(s.velocity)
        flock(ways, velocity, stimuli, s.arrived, self._fixed, self._numbers, self._gains, pull)
        return pull

    def reset(self, world: int, seed: int) -> None:
        """There is nothing to forget."""
