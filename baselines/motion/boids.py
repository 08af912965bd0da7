"""Boids: alignment, separation, cohesion, home and goal, with fixed or adaptive gains.

Smith et al. 2021 (BOIDS), Sections II.2 and III.1. The rules steer e-pucks that know their goal,
within the subsumption of Gutierrez et al. 2009 (TR), Section 5.1.

Not in the paper, and as in the authors' code: every rule seeks its direction from the present
velocity (`seek`); the sum is a pull at full strength; a robot that has just claimed its goal
follows the other rules until it has a new one; gains are not clamped, so that they turn negative
where a stimulus exceeds its allowed value. Robots that visit waypoints are commanded an
acceleration; e-pucks are steered by `steer_epuck`.
"""

import math
from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from baselines.motion.base import MOTIONS
from baselines.motion.subsumption import (
    WHERE_A_LEARNER_STEERS,
    Course,
    SubsumptionParameters,
    subsume,
)
from swarm_forage_env.arrays import NEST, Array, Float32, Float64
from swarm_forage_env.compiler import kernel
from swarm_forage_env.epuck import records as epuck
from swarm_forage_env.equations.elementary import cos_sin, hypot
from swarm_forage_env.equations.steering import seek
from swarm_forage_env.foraging.inputs import goal_of
from swarm_forage_env.foraging.records import Situation as Foraging
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.interface import MotionLayer
from swarm_forage_env.parameters import NotNegative, Parameters, Positive
from swarm_forage_env.record import Numbers, Record, field
from swarm_forage_env.waypoints.records import Readings, Situation
from swarm_forage_env.waypoints.scenario import WaypointsScenario

STATIC = "with static gains. BOIDS, authors' code (code)"

ALIGN, SEPARATE, COHERE, HOME, GOAL = range(5)
"""Indices of the rules in `Ways` and `Gains`."""

N_RULES = 5

Vector = Float32[Array, "2"]

Ways = Float32[Array, "5 2"] | tuple[Vector, Vector, Vector, Vector, Vector]
"""Direction of each rule, body frame."""

Gains = Float64[Array, "5"]  # the gain of each rule

Stimuli = Float32[Array, "3"] | tuple[float, float, float]
"""Robots seen, uncertainty, distance from dead reckoning: each as a share of its maximum."""


@kernel
def adaptive_gains(
    rho: float, s: float, e: float, d_g: float, d_h: float, out_gains: Gains
) -> None:
    """Write the adaptive gains for the stimuli of a robot.

        K_a = rho + (1 - d_h) + e
        K_s = (1 - e) + (1 - d_g) + (1 - s)
        K_c = s + e + d_h
        K_h = s + e + (1 - d_h)
        K_g = (1 - s) + (1 - e) + (1 - d_g)

    rho: robots seen, as a share of all; s: norm of the covariance, e: distance from dead
    reckoning, each as a share of its largest allowed value; d_g, d_h: distance to the goal and
    to home, as a share of the side of the world.

    Source: BOIDS, Eq. 33 to 37.
    """
    out_gains[ALIGN] = rho + (1.0 - d_h) + e
    out_gains[SEPARATE] = (1.0 - e) + (1.0 - d_g) + (1.0 - s)
    out_gains[COHERE] = s + e + d_h
    out_gains[HOME] = s + e + (1.0 - d_h)
    out_gains[GOAL] = (1.0 - s) + (1.0 - e) + (1.0 - d_g)


@kernel
def choose_gains(ways: Ways, stimuli: Stimuli, numbers: Numbers, out_gains: Gains) -> None:
    """Write the fixed gains or, if `adaptive`, those for the stimuli (rho, s, e) and `ways`."""
    if numbers.adaptive > 0.0:
        goal, home = ways[GOAL], ways[HOME]
        d_g, d_h = hypot(goal[0], goal[1]) / numbers.side, hypot(home[0], home[1]) / numbers.side
        adaptive_gains(stimuli[0], stimuli[1], stimuli[2], d_g, d_h, out_gains)
    else:
        for rule in range(N_RULES):
            out_gains[rule] = numbers.gains[rule]


@kernel
def sum_of_rules(
    gains: Gains, ways: Ways, velocity: Vector, max_speed: float
) -> tuple[float, float]:
    """Return the combined pull of all rules on a robot: a unit vector, or zeros.

        A = sum over rules of K F,  A / |A|

    Each force F seeks the direction of its rule from the current velocity.

    Source: BOIDS, Eq. 27.
    """
    x, y = 0.0, 0.0
    vx, vy = float(velocity[0]), float(velocity[1])
    for rule in range(N_RULES):
        way = ways[rule]
        fx, fy = seek(float(way[0]), float(way[1]), vx, vy, max_speed)
        x += gains[rule] * fx
        y += gains[rule] * fy
    size = hypot(x, y)
    return (x / size, y / size) if size > 0.0 else (0.0, 0.0)


class FlockMemory(Record):
    """Memory of boids for one robot: the gains of its rules. Writer: `steer`."""

    gains: Gains = field(np.float64, 5)
    """Gains of alignment, separation, cohesion, home and goal."""


@kernel
def steer(
    situation: Situation, readings: Readings, acceleration: Vector, memory: FlockMemory,
    numbers: Numbers,
) -> None:  # fmt: skip
    """Write the acceleration of all rules, body frame; the gain of a goal just claimed is 0."""
    s = situation
    ways = (s.alignment, s.separation, s.centre, s.home, s.goal)
    stimuli = (s.density, s.covariance_norm, s.dead_reckoning_offset)
    choose_gains(ways, stimuli, numbers, memory.gains)
    if s.has_arrived:
        memory.gains[GOAL] = 0.0
    x, y = sum_of_rules(memory.gains, ways, s.velocity, numbers.max_speed)
    acceleration[0], acceleration[1] = x, y


class FlockCourse(Course):
    """Course of a robot, and the quantities of one tick of boids. Writer: `steer_epuck`."""

    ways: Float32[Array, "5 2"] = field(np.float32, 5, 2, unit="m")
    """Direction of each rule, body frame: mean course of the neighbours, away from them, to their
    centre, to home, to the goal."""
    stimuli: Float32[Array, "3"] = field(np.float32, 3)
    """Robots heard, p of the goal, distance from dead reckoning: each as a share of its maximum."""
    gains: Gains = field(np.float64, 5)
    """Gain of each rule."""
    velocity: Vector = field(np.float32, 2, unit="m/s")
    """Velocity of the robot, body frame."""
    pull: Vector = field(np.float32, 2)
    """Combined pull of all rules, body frame: a unit vector, or zeros."""


@kernel
def see_neighbours(heard: epuck.Heard, ways: Float32[Array, "5 2"]) -> None:
    """Write the directions of alignment, separation and cohesion from the messages received.

    Source: BOIDS, Eq. 21 to 23, of what an e-puck hears.
    """
    cx, cy, fx, fy = 0.0, 0.0, 0.0, 0.0
    for slot in range(heard.n):
        beam = heard.range_bearing[slot]
        ahead = float(beam[1])
        c, s = cos_sin(ahead)
        cx += beam[0] * c
        cy += beam[0] * s
        course = ahead + math.pi - float(beam[2])
        c, s = cos_sin(course)
        fx += c
        fy += s
    n = max(heard.n, 1)
    ways[ALIGN, 0], ways[ALIGN, 1] = fx / n, fy / n
    ways[SEPARATE, 0], ways[SEPARATE, 1] = -cx, -cy
    ways[COHERE, 0], ways[COHERE, 1] = cx / n, cy / n


@kernel
def feel(situation: Foraging, heard: epuck.Heard, course: FlockCourse, numbers: Numbers) -> None:
    """Write the directions of all rules and the stimuli (rho, s, e) of a robot that forages.

    Source: BOIDS, Eq. 28 to 30, of what an e-puck hears.
    """
    see_neighbours(heard, course.ways)
    for axis in range(2):
        course.ways[HOME, axis] = situation.areas[NEST, axis]
        course.ways[GOAL, axis] = situation.target[axis]
    course.stimuli[0] = heard.n / numbers.n_robots
    course.stimuli[1] = course.stimuli[2] = 0.0
    goal = goal_of(situation.goal)
    if goal >= 0:
        course.stimuli[1] = situation.p[goal] / numbers.trust


@kernel
def steer_epuck(
    situation: Foraging,
    readings: epuck.Readings,
    heard: epuck.Heard,
    wheels: Vector,
    course: FlockCourse,
    numbers: Numbers,
) -> None:
    """Steer by subsumption with the pull as target; `wheels` hold the last command, then the next.

    Not in the papers, and chosen here:
    - talking, avoiding and the random walk of `subsumption` stay as they are; the rules replace the
      straight way to the goal;
    - neighbours are the senders heard in this tick, in the direction and distance of their beams;
      which way they go follows from the bearings at both ends;
    - home is the nest, as far as it is known; the length of the world is the arena's longer side;
    - the stimulus of the covariance is p of the goal, as a share of `trust`; an e-puck cannot measure
      its distance from dead reckoning, so that e = 0.
    """  # noqa: E501 as on the page
    feel(situation, heard, course, numbers)
    mean = (wheels[0] + wheels[1]) * np.float32(0.5)
    course.velocity[0] = np.float32(numbers.max_speed) * mean
    choose_gains(course.ways, course.stimuli, numbers, course.gains)
    x, y = sum_of_rules(course.gains, course.ways, course.velocity, numbers.max_speed)
    course.pull[0], course.pull[1] = x, y
    subsume(situation, readings, course.pull, wheels, course, numbers)


@MOTIONS.register("boids")
class BoidsParameters(Parameters):
    """Boids: the sum of the rules for neighbours, home and goal, each with a gain."""

    tasks: ClassVar[tuple[str, ...]] = ("foraging", "waypoints")
    gains: Literal["goal", "static", "adaptive"] = Field(
        "adaptive",
        description="Gains: of the goal alone, fixed as below, or of Eq. 33 to 37 (published)",
    )
    alignment: NotNegative = Field(1.0, description=f"Gain K_a of alignment {STATIC}")
    separation: NotNegative = Field(1.0, description=f"Gain K_s of separation {STATIC}")
    cohesion: NotNegative = Field(1.0, description=f"Gain K_c of cohesion {STATIC}")
    homing: NotNegative = Field(1.0, description=f"Gain K_h of homing {STATIC}")
    seeking: NotNegative = Field(1.0, description=f"Gain K_g of the goal {STATIC}")
    trust: Positive = Field(
        10.0,
        description="In foraging, p of the goal at which trust in it has fallen to zero [m]: a"
        " path, or a standard deviation of the covariance filters (chosen)",
    )

    @property
    def fixed(self) -> tuple[float, float, float, float, float]:
        """Gains of the rules if they do not adapt."""
        if self.gains == "goal":
            return 0.0, 0.0, 0.0, 0.0, 1.0
        return self.alignment, self.separation, self.cohesion, self.homing, self.seeking

    def layer(self, scenario: Scenario | WaypointsScenario) -> MotionLayer:
        """Return the compiled motion with its parameters in a scenario."""
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
        return MotionLayer(steer_epuck, numbers, FlockCourse, kernels=WHERE_A_LEARNER_STEERS)
