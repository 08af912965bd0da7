"""Boids among robots that visit waypoints: the rules command an acceleration.

Smith et al. 2021 (BOIDS), Sections 3 and 4.
"""

from typing import TYPE_CHECKING

import numpy as np

from baselines.motion.flock import GOAL, N_RULES, adaptive_gains, sum_of_rules
from swarm_forage_env.arrays import Array, Float32, Float64
from swarm_forage_env.compiler import kernel
from swarm_forage_env.equations.elementary import hypot
from swarm_forage_env.interface import MotionLayer
from swarm_forage_env.record import Numbers, Record, field
from swarm_forage_env.waypoints.records import Readings, Situation
from swarm_forage_env.waypoints.scenario import WaypointsScenario

if TYPE_CHECKING:
    from baselines.motion.boids import BoidsParameters


class Gains(Record):
    """What boids keep of a robot: the gains that it goes by. Writer: `choose_gains`."""

    gains: Float64[Array, "5"] = field(np.float64, 5)
    """Of alignment, separation, cohesion, home and goal."""


@kernel
def choose_gains(situation: Situation, numbers: Numbers, out_gains: Float64[Array, "5"]) -> None:
    """The fixed gains, or those that adapt; none for a goal that is claimed already."""
    if numbers.adaptive > 0.0:
        goal, home = situation.goal, situation.home
        d_g = hypot(goal[0], goal[1]) / numbers.side
        d_h = hypot(home[0], home[1]) / numbers.side
        adaptive_gains(
            situation.density, situation.covariance_norm, situation.dead_reckoning_offset,
            d_g, d_h, out_gains,
        )  # fmt: skip
    else:
        for rule in range(N_RULES):
            out_gains[rule] = numbers.fixed[rule]
    if situation.has_arrived:
        out_gains[GOAL] = 0.0


@kernel
def steer(
    situation: Situation,
    readings: Readings,
    acceleration: Float32[Array, "2"],
    memory: Gains,
    numbers: Numbers,
) -> None:
    """The acceleration by all rules, in the body frame."""
    choose_gains(situation, numbers, memory.gains)
    s = situation
    ways = (s.alignment, s.separation, s.centre, s.home, s.goal)
    x, y = sum_of_rules(memory.gains, ways, s.velocity, numbers.max_speed)
    acceleration[0], acceleration[1] = x, y


def layer(parameters: "BoidsParameters", scenario: WaypointsScenario) -> MotionLayer:
    """The functions of the motion, with its numbers in a scenario."""
    numbers = {
        "adaptive": parameters.gains == "adaptive",
        "fixed": parameters.fixed,
        "side": scenario.task.side,
        "max_speed": scenario.robot.max_speed,
    }
    return MotionLayer(steer, numbers, Gains)
