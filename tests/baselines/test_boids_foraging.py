"""Boids where e-pucks forage: what the rules see, and what they leave to subsumption."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from baselines.motion import boids_foraging, subsumption
from baselines.motion.boids import BoidsParameters
from baselines.motion.boids_foraging import FlockCourse
from baselines.motion.flock import ALIGN, COHERE, GOAL, HOME, SEPARATE, adaptive_gains
from baselines.motion.subsumption import Course, SubsumptionParameters
from swarm_forage_env.arrays import NEST, PREY
from swarm_forage_env.epuck.records import Heard, Readings
from swarm_forage_env.foraging.records import Situation
from swarm_forage_env.random_streams import NoiseSource, streams
from swarm_forage_env.record import rows
from swarm_forage_env.scenarios import find_scenario

SCENARIO = find_scenario("es1")
SPEED, SIDE = SCENARIO.robot.cruise_speed, max(SCENARIO.arena.length, SCENARIO.arena.width)
TRUST = 10.0

every_rule = pytest.mark.parametrize("gains", ["goal", "static", "adaptive"])

ONE_OF = np.eye(3)
"""A goal as layers see it: nest, prey, none."""


class Robot:
    """A robot that knows both areas, heads for the prey, and hears two others."""

    def __init__(self, seed):
        rng = np.random.default_rng(seed)
        self.situation, self.readings = one(Situation), one(Readings)
        self.heard = rows(Heard.array((1,), slots=4))[0]
        self.situation.areas[:] = rng.normal(size=(2, 2))
        self.situation.target[:] = self.situation.areas[PREY]
        self.situation.p[:] = rng.uniform(0.0, 15.0, 2)
        self.situation.known[:], self.situation.goal[:] = True, ONE_OF[PREY]
        self.heard.n = 2
        self.heard.range_bearing[:2] = (0.1, 0.5, -2.0), (0.06, -1.0, 0.3)
        self.last_wheels = np.array([0.4, 0.8], np.float32)

    def steer(self, steer, course, numbers):
        """The wheels that a motion gives."""
        wheels = self.last_wheels.copy()
        course.stream[:] = streams([3], 1, NoiseSource.WANDER)[0]
        steer(self.situation, self.readings, self.heard, wheels, course, numbers)
        return wheels


def one(kind):
    return rows(kind.array((1,)))[0]


@pytest.fixture(scope="module")
def boids(numbers_of):
    """The wheels of a robot under boids, and what they were decided from."""

    def steer(robot, **parameters):
        numbers = numbers_of(boids_foraging.layer(BoidsParameters(**parameters), SCENARIO).numbers)
        course = one(FlockCourse)
        return robot.steer(boids_foraging.steer, course, numbers), course

    return steer


@pytest.fixture(scope="module")
def subsume(numbers_of):
    """The wheels of a robot under subsumption alone."""
    numbers = numbers_of(SubsumptionParameters().numbers(SCENARIO))
    return lambda robot: robot.steer(subsumption.steer, one(Course), numbers)


def unit(v):
    size = np.linalg.norm(v)
    return v / size if size > 0.0 else np.zeros(2)


def direction(angle):
    return np.array([math.cos(angle), math.sin(angle)])


def test_neighbours_are_where_their_beams_come_from_and_go_where_the_bearings_say(boids):
    robot = Robot(0)
    course = boids(robot)[1]
    beams = robot.heard.range_bearing[:2].astype(float)
    places = np.array([r * direction(b) for r, b, _ in beams])
    headings = np.array([direction(b + math.pi - back) for _, b, back in beams])
    assert_allclose(course.ways[ALIGN], headings.mean(axis=0), atol=1e-6)
    assert_allclose(course.ways[SEPARATE], -places.sum(axis=0), atol=1e-6)
    assert_allclose(course.ways[COHERE], places.mean(axis=0), atol=1e-6)
    assert_array_equal(course.ways[HOME], robot.situation.areas[NEST])
    assert_array_equal(course.ways[GOAL], robot.situation.target)


@pytest.mark.parametrize(("goal", "share"), [(NEST, 0.2), (PREY, 0.7), (-1, 0.0)])
def test_the_stimuli_are_the_neighbours_and_the_doubt_about_the_goal(boids, goal, share):
    robot = Robot(0)
    robot.situation.goal[:], robot.situation.p[:] = ONE_OF[goal], (2.0, 7.0)
    stimuli = boids(robot, trust=TRUST)[1].stimuli
    assert_allclose(stimuli, [2 / SCENARIO.task.n_robots, share, 0.0], atol=1e-7)


@every_rule
@given(seed=st.integers(0, 2**32))
def test_the_rules_sum_up_to_the_pull(boids, gains, seed):
    robot = Robot(seed)
    course = boids(robot, gains=gains, alignment=0.3, seeking=1.3)[1]
    expected = np.array([0.3, 1.0, 1.0, 1.0, 1.3]) if gains == "static" else np.eye(5)[GOAL]
    if gains == "adaptive":
        far = np.linalg.norm(robot.situation.areas.astype(float), axis=1) / SIDE
        p = robot.situation.p[PREY] / TRUST
        adaptive_gains(2 / SCENARIO.task.n_robots, p, 0.0, far[PREY], far[NEST], expected)
    velocity = np.array([SPEED * robot.last_wheels.mean(), 0.0])
    forces = [unit(SPEED * unit(way.astype(float)) - velocity) for way in course.ways]
    assert_allclose(course.gains, expected, rtol=1e-5)
    assert_allclose(course.pull, unit(expected @ forces), atol=1e-4)


@every_rule
def test_avoiding_and_the_random_walk_are_those_of_subsumption(boids, subsume, gains):
    blocked, lost = Robot(2), Robot(3)
    blocked.readings.proximity[0] = 0.9
    lost.situation.goal[:] = ONE_OF[-1]
    for robot in (blocked, lost):
        assert_array_equal(boids(robot, gains=gains)[0], subsume(robot))
