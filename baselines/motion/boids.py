"""Boids: alignment, separation, cohesion, home and goal, with fixed or adaptive gains.

Smith et al. 2021 (BOIDS), Sections 3 and 4.

Not in the paper, and as in the authors' code: every rule seeks its direction from the present
velocity (`seek`); the sum is a pull at full strength; a robot that has just claimed its goal
follows the other rules until it has a new one; gains are not clamped, so that they turn negative
where a stimulus exceeds its allowed value. Robots that visit waypoints are commanded an
acceleration; e-pucks are steered by `boids_foraging`.
"""

from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from baselines.motion import boids_foraging
from baselines.motion.base import MOTIONS
from baselines.motion.boids_foraging import FlockCourse
from baselines.motion.flock import GOAL, Gains, Vector, choose_gains, sum_of_rules
from baselines.motion.subsumption import WHERE_A_LEARNER_STEERS, SubsumptionParameters
from swarm_forage_env.compiler import kernel
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.interface import MotionLayer
from swarm_forage_env.parameters import NotNegative, Parameters, Positive
from swarm_forage_env.record import Numbers, Record, field
from swarm_forage_env.waypoints.records import Readings, Situation
from swarm_forage_env.waypoints.scenario import WaypointsScenario

STATIC = "of static gains. BOIDS, authors' code (code)"


class FlockMemory(Record):
    """What boids keep of a robot: the gains of its rules. Writer: `steer`."""

    gains: Gains = field(np.float64, 5)
    """Of alignment, separation, cohesion, home and goal."""


@kernel
def steer(
    situation: Situation, readings: Readings, acceleration: Vector, memory: FlockMemory,
    numbers: Numbers,
) -> None:  # fmt: skip
    """Write the acceleration by all rules, in the body frame; no gain for a goal just claimed."""
    s = situation
    ways = (s.alignment, s.separation, s.centre, s.home, s.goal)
    stimuli = (s.density, s.covariance_norm, s.dead_reckoning_offset)
    choose_gains(ways, stimuli, numbers, memory.gains)
    if s.has_arrived:
        memory.gains[GOAL] = 0.0
    x, y = sum_of_rules(memory.gains, ways, s.velocity, numbers.max_speed)
    acceleration[0], acceleration[1] = x, y


@MOTIONS.register("boids")
class BoidsParameters(Parameters):
    """Boids: a robot adds up the rules of its neighbours and its goal, each with a gain."""

    tasks: ClassVar[tuple[str, ...]] = ("foraging", "waypoints")
    gains: Literal["goal", "static", "adaptive"] = Field(
        "adaptive", description="Goal alone, the fixed gains below, or those of Eq. 33-37"
    )
    alignment: NotNegative = Field(1.0, description=f"K_a {STATIC}")
    separation: NotNegative = Field(1.0, description=f"K_s {STATIC}")
    cohesion: NotNegative = Field(1.0, description=f"K_c {STATIC}")
    homing: NotNegative = Field(1.0, description=f"K_h {STATIC}")
    seeking: NotNegative = Field(1.0, description=f"K_g {STATIC}")
    trust: Positive = Field(
        10.0,
        description="Where robots forage, p of the goal at which nothing is trusted any more: a"
        " path [m], or of the covariance filters a standard deviation [m] (chosen)",
    )

    @property
    def fixed(self) -> tuple[float, float, float, float, float]:
        """The gains of the rules where they do not adapt."""
        if self.gains == "goal":
            return 0.0, 0.0, 0.0, 0.0, 1.0
        return self.alignment, self.separation, self.cohesion, self.homing, self.seeking

    def layer(self, scenario: Scenario | WaypointsScenario) -> MotionLayer:
        """The functions of the motion, with its numbers in a scenario."""
        gains = {"adaptive": self.gains == "adaptive", "gains": self.fixed}
        if isinstance(scenario, WaypointsScenario):
            size = {"side": scenario.task.side, "max_speed": scenario.robot.max_speed}
            return MotionLayer(steer, gains | size, FlockMemory)
        numbers = {
            **SubsumptionParameters().numbers(scenario),
            **gains,
            "side": max(scenario.arena.length, scenario.arena.width),
            "max_speed": scenario.robot.cruise_speed,
            "n_robots": scenario.task.n_robots,
            "trust": self.trust,
        }
        return MotionLayer(
            boids_foraging.steer, numbers, FlockCourse, kernels=WHERE_A_LEARNER_STEERS
        )
