"""Subsumption motion: talk, avoid, forage, wander; the first behaviour that applies steers.

Gutierrez et al. 2009 (TR), Section 5.

Not in the paper, and chosen here:
- communicating comes first: "the communication layer takes control of the motors' output";
- avoidance is tangential and keeps right (`tangential`): with the published "opposite to the
  vector" (`literal`) robots jam head-on on the path. The vector is of the sensors within `sector`,
  where the TR has all of them; and a robot that avoids keeps creeping ahead;
- the random walk: straight runs of exponential length, then a turn to a uniform direction;
- the steering: forward share cos(angle), turning share proportional to the angle.
"""

import math
from typing import Literal

import numpy as np
from pydantic import Field

from baselines.motion.base import MOTIONS
from swarm_forage_env.arrays import Array, Float32, UInt64
from swarm_forage_env.compiler import kernel
from swarm_forage_env.epuck.records import Heard, Readings
from swarm_forage_env.epuck.scenario import EpuckScenario
from swarm_forage_env.equations.differential_drive import wheels_towards
from swarm_forage_env.equations.elementary import atan2, cos_sin
from swarm_forage_env.equations.geometry import wrap
from swarm_forage_env.equations.proximity import PROXIMITY_ANGLES, RAY_COS, RAY_SIN, response
from swarm_forage_env.equations.random_draws import exponential, symmetric
from swarm_forage_env.foraging.inputs import goal_of
from swarm_forage_env.foraging.records import Situation
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.interface import Kernel, MotionLayer
from swarm_forage_env.parameters import NotNegative, Parameters, Positive, Share
from swarm_forage_env.record import Numbers, Record, field

Wheels = Float32[Array, "2"]  # left and right wheel speeds, as shares of the maximum

KEEP_RIGHT = -math.pi / 6.0
"""Bearing below which an obstacle is passed on its left, else on its right [rad] (chosen). Robots
keep right: without a preferred side, two that meet head-on may choose the same one."""


class Course(Record):
    """Course of a robot. Writer: `subsume`."""

    hold: float = field(np.float64, unit="ticks")
    """Remaining ticks for which the course of an avoidance is held."""
    turn: float = field(np.float64, unit="rad")
    """Remaining angle to the course."""
    run: float = field(np.float64, unit="m")
    """Remaining path of the straight run."""
    stream: UInt64[Array, "1"] = field(np.uint64, 1)
    """Random stream of the random walk."""


@kernel
def obstacle(proximity: Float32[Array, "8"], threshold: float, sector: float) -> tuple[bool, float]:
    """Return whether there is an obstacle to avoid, and its bearing in the body frame [rad].

    The bearing is that of the vector sum of the sensors above the threshold within the sector.

    Source: TR, Section 5.1 (avoid).
    """
    nearest = proximity[0]
    for k in range(1, 8):
        nearest = max(nearest, proximity[k])
    if nearest <= threshold:  # the usual case: skips eight branches that are hard to predict
        return False, 0.0
    x, y = 0.0, 0.0
    for k in range(8):
        if proximity[k] > threshold and abs(PROXIMITY_ANGLES[k]) <= sector:
            x += proximity[k] * RAY_COS[k]
            y += proximity[k] * RAY_SIN[k]
    if x == 0.0 and y == 0.0:
        return False, 0.0
    return True, atan2(y, x)


@kernel
def way_round(bearing: float, swerve: float, side: float) -> float:
    """Return the course past an obstacle, body frame [rad]: on its left if bearing < side."""
    return wrap(bearing + swerve) if bearing < side else wrap(bearing - swerve)


@kernel
def avoid(course: Course, readings: Readings, numbers: Numbers, side: float) -> bool:
    """Set a course past an obstacle, if there is one; returns whether a course is held."""
    seen, bearing = obstacle(readings.proximity, response(numbers.gap), numbers.sector)
    if seen:
        if numbers.literal > 0.0:
            course.turn = wrap(bearing + math.pi)
        else:
            course.turn = way_round(bearing, numbers.swerve, side)
        course.hold = numbers.hold_ticks
    if not seen and course.hold <= 0.0:
        return False
    course.hold -= 1.0
    return True


@kernel
def wander(course: Course, numbers: Numbers) -> None:
    """Continue a straight run of the random walk, or start a new one."""
    if course.run <= 0.0:
        course.run = exponential(course.stream, 0, numbers.mean_run)
        course.turn = math.pi * symmetric(course.stream, 0)
    course.run -= numbers.path_per_tick


@kernel
def head_for(angle: float, creep: float, wheels: Wheels, course: Course, numbers: Numbers) -> None:
    """Write wheel speeds towards a direction in the body frame [rad]; update the course angle."""
    left, right = wheels_towards(angle, creep)
    course.turn = wrap(course.turn - 0.5 * (right - left) * numbers.turn_per_tick)
    wheels[0], wheels[1] = left, right


@kernel
def react(
    situation: Situation,
    readings: Readings,
    wheels: Wheels,
    course: Course,
    numbers: Numbers,
    side: float,
) -> bool:
    """Stop while talking, or avoid an obstacle; returns whether either applied."""
    if situation.is_talking:
        wheels[0] = wheels[1] = 0.0
        return True
    if not avoid(course, readings, numbers, side):
        return False
    head_for(course.turn, numbers.creep, wheels, course, numbers)
    return True


@kernel
def reflex(
    situation: Situation, readings: Readings, wheels: Wheels, course: Course, numbers: Numbers
) -> bool:
    """Apply `react` under a policy: obstacles are passed on either side, as the policy steers."""
    return react(situation, readings, wheels, course, numbers, 0.0)


@kernel
def walk(
    situation: Situation, wheels: Wheels, is_free: bool, course: Course, numbers: Numbers
) -> None:
    """Continue the random walk of a robot steered by a policy, and write its course.

    `is_free`: no reflex applied; a reflex updates the course itself.
    """
    if is_free:
        if goal_of(situation.goal) < 0:
            wander(course, numbers)
        turned = 0.5 * (wheels[1] - wheels[0]) * numbers.turn_per_tick
        course.turn = wrap(course.turn - turned)
    situation.walk[0], situation.walk[1] = cos_sin(course.turn)


WHERE_A_LEARNER_STEERS: dict[str, Kernel] = {"reflex": reflex, "walk": walk}
"""Parts of subsumption that run under a policy."""


@kernel
def subsume(
    situation: Situation,
    readings: Readings,
    target: Float32[Array, "2"],
    wheels: Wheels,
    course: Course,
    numbers: Numbers,
) -> None:
    """Run one tick of all behaviours in this order: stop to talk, avoid, forage, wander.

    A robot with a goal drives to `target`, body frame [m].
    """
    if react(situation, readings, wheels, course, numbers, KEEP_RIGHT):
        return
    if goal_of(situation.goal) >= 0:
        angle = atan2(target[1], target[0])
    else:
        wander(course, numbers)
        angle = course.turn
    head_for(angle, 0.0, wheels, course, numbers)


@kernel
def steer(
    situation: Situation,
    readings: Readings,
    heard: Heard,
    wheels: Wheels,
    course: Course,
    numbers: Numbers,
) -> None:
    """Steer by subsumption to the target of the robot, and write its wheel speeds."""
    subsume(situation, readings, situation.target, wheels, course, numbers)


@MOTIONS.register("subsumption")
class SubsumptionParameters(Parameters):
    """Subsumption: a robot talks, else avoids obstacles, else goes to its goal, else wanders."""

    avoidance: Literal["tangential", "literal"] = Field(
        "tangential", description="Way around the obstacle (chosen), or opposite to it as in TR 5.1"
    )
    gap: Positive = Field(
        0.011, le=0.05, description="Distance below which obstacles are avoided [m] (derived)"
    )
    sector: Positive = Field(
        math.radians(100.0),
        le=math.pi,
        description="Angle off the heading above which obstacles are ignored [rad] (derived)",
    )
    swerve: Positive = Field(
        math.radians(100.0),
        le=math.pi,
        description="New course, measured from the obstacle's bearing [rad] (derived)",
    )
    hold: NotNegative = Field(0.0, description="Duration of the new course [s] (derived)")
    creep: Share = Field(
        0.15, description="Smallest forward share of the speed while avoiding (derived)"
    )
    mean_run: Positive = Field(
        0.33, description="Mean straight run of the random walk [m] (derived)"
    )

    def layer(self, scenario: Scenario) -> MotionLayer:
        """Return the compiled motion with its parameters in a scenario."""
        own = self.numbers(scenario)
        return MotionLayer(steer, own, Course, kernels=WHERE_A_LEARNER_STEERS)

    def numbers(self, scenario: EpuckScenario) -> dict[str, float]:
        """Return the parameters for kernels, including those of subclasses; times are in ticks."""
        cruise, dt = scenario.robot.cruise_speed, scenario.tick
        own = {name: each for name, each in self if isinstance(each, int | float)}
        del own["hold"]
        return own | {
            "literal": self.avoidance == "literal",
            "hold_ticks": round(self.hold / dt),
            "path_per_tick": cruise * dt,
            "turn_per_tick": 2.0 * cruise * dt / scenario.robot.axle,
        }
