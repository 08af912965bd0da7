"""Boids among e-pucks: the rules steer a robot that knows its goal, over avoidance and walk.

Smith et al. 2021 (BOIDS), Section 3, over Gutierrez et al. 2009 (TR), Section 5.1.

Not in the papers, and chosen here:
- talking, avoiding and the random walk of `subsumption` stay as they are; the rules replace the
  straight way to the goal;
- neighbours are the senders heard in this tick, in the direction and distance of their beams;
  which way they go follows from the bearings at both ends;
- home is the nest, as far as it is known; the length of the world is the arena's longer side;
- the stimulus of the covariance is p of the goal, as a share of `trust`; an e-puck cannot measure
  its distance from dead reckoning, so that e = 0.
"""

import math

import numpy as np

from baselines.motion.flock import (
    ALIGN,
    COHERE,
    GOAL,
    HOME,
    SEPARATE,
    Gains,
    Vector,
    choose_gains,
    sum_of_rules,
)
from baselines.motion.subsumption import Course, subsume
from swarm_forage_env.arrays import NEST, Array, Float32
from swarm_forage_env.compiler import kernel
from swarm_forage_env.epuck.records import Heard, Readings
from swarm_forage_env.equations.elementary import cos_sin
from swarm_forage_env.foraging.inputs import goal_of
from swarm_forage_env.foraging.records import Situation
from swarm_forage_env.record import Numbers, field


class FlockCourse(Course):
    """A robot's course, and the quantities of one tick of boids. Writer: `steer`."""

    ways: Float32[Array, "5 2"] = field(np.float32, 5, 2, unit="m")
    """Where each rule points, body frame: flow, away from the neighbours, their centre, home,
    goal."""
    stimuli: Float32[Array, "3"] = field(np.float32, 3)
    """Robots heard, p of the goal, distance from dead reckoning: each as a share of the most."""
    gains: Gains = field(np.float64, 5)
    """Gain of each rule."""
    velocity: Vector = field(np.float32, 2, unit="m/s")
    """Of the robot, body frame."""
    pull: Vector = field(np.float32, 2)
    """Unit vector of the pull of all rules, body frame; or zeros."""


@kernel
def see_neighbours(heard: Heard, ways: Float32[Array, "5 2"]) -> None:
    """Write the ways of the rules of the neighbours heard: flow, separation, cohesion.

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
def feel(situation: Situation, heard: Heard, course: FlockCourse, numbers: Numbers) -> None:
    """Write the ways of all rules and the stimuli (rho, s, e) of a robot that forages.

    Source: BOIDS, Section 4, of what an e-puck hears.
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
def steer(
    situation: Situation,
    readings: Readings,
    heard: Heard,
    wheels: Vector,
    course: FlockCourse,
    numbers: Numbers,
) -> None:
    """Subsumption with the pull of the rules as target; `wheels` are the last, and the next."""
    feel(situation, heard, course, numbers)
    mean = (wheels[0] + wheels[1]) * np.float32(0.5)
    course.velocity[0] = np.float32(numbers.max_speed) * mean
    choose_gains(course.ways, course.stimuli, numbers, course.gains)
    x, y = sum_of_rules(course.gains, course.ways, course.velocity, numbers.max_speed)
    course.pull[0], course.pull[1] = x, y
    subsume(situation, readings, course.pull, wheels, course, numbers)
