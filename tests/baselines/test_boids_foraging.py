"""Boids where e-pucks forage: what the rules see, and what they sum up to."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from baselines.motion import boids_foraging
from baselines.motion.boids import BoidsParameters
from baselines.motion.boids_foraging import FlockCourse
from baselines.motion.flock import ALIGN, COHERE, GOAL, HOME, SEPARATE, adaptive_gains
from swarm_forage_env.arrays import NEST, PREY
from swarm_forage_env.epuck.records import Heard, Readings
from swarm_forage_env.foraging.records import Situation
from swarm_forage_env.record import rows
from swarm_forage_env.scenarios import find_scenario

SCENARIO = find_scenario("es1")
SPEED, SIDE = SCENARIO.robot.cruise_speed, max(SCENARIO.arena.length, SCENARIO.arena.width)
BEAMS = np.array([(0.1, 0.5, -2.0), (0.06, -1.0, 0.3)])
"""Range and bearings of the two robots that are heard."""

WHEELS = np.array([0.4, 0.8], np.float32)


@pytest.fixture(scope="module")
def boids(numbers_of):
    """What a robot sees that knows both areas and heads for the prey; by what it is steered."""

    def steer(seed, **parameters):
        numbers = numbers_of(boids_foraging.layer(BoidsParameters(**parameters), SCENARIO).numbers)
        rng, heard = np.random.default_rng(seed), rows(Heard.array((1,), slots=4))[0]
        seen, readings, course = (
            rows(kind.array((1,)))[0] for kind in (Situation, Readings, FlockCourse)
        )
        seen.areas[:], seen.p[:] = rng.normal(size=(2, 2)), rng.uniform(0.0, 15.0, 2)
        seen.target[:], seen.known[:], seen.goal[:] = seen.areas[PREY], True, np.eye(3)[PREY]
        heard.n, heard.range_bearing[:2] = 2, BEAMS
        boids_foraging.steer(seen, readings, heard, WHEELS.copy(), course, numbers)
        return seen, course

    return steer


def unit(v):
    size = np.linalg.norm(v)
    return v / size if size > 0.0 else np.zeros(2)


def direction(angle):
    return np.array([math.cos(angle), math.sin(angle)])


def test_neighbours_are_where_their_beams_come_from_and_go_where_the_bearings_say(boids):
    seen, course = boids(0)
    places = np.array([r * direction(b) for r, b, _ in BEAMS])
    headings = np.array([direction(b + math.pi - back) for _, b, back in BEAMS])
    assert_allclose(course.ways[ALIGN], headings.mean(axis=0), atol=1e-6)
    assert_allclose(course.ways[SEPARATE], -places.sum(axis=0), atol=1e-6)
    assert_allclose(course.ways[COHERE], places.mean(axis=0), atol=1e-6)
    assert_array_equal(course.ways[HOME], seen.areas[NEST])
    assert_array_equal(course.ways[GOAL], seen.target)


@pytest.mark.parametrize("gains", ["goal", "static", "adaptive"])
@given(seed=st.integers(0, 2**32))
def test_the_rules_sum_up_to_the_pull(boids, gains, seed):
    seen, course = boids(seed, gains=gains, alignment=0.3, seeking=1.3)
    expected = np.array([0.3, 1.0, 1.0, 1.0, 1.3]) if gains == "static" else np.eye(5)[GOAL]
    if gains == "adaptive":
        far = np.linalg.norm(seen.areas.astype(float), axis=1) / SIDE
        p = seen.p[PREY] / BoidsParameters().trust
        adaptive_gains(2 / SCENARIO.task.n_robots, p, 0.0, far[PREY], far[NEST], expected)
    velocity = np.array([SPEED * WHEELS.mean(), 0.0])
    forces = [unit(SPEED * unit(way.astype(float)) - velocity) for way in course.ways]
    assert_allclose(course.gains, expected, rtol=1e-5)
    assert_allclose(course.pull, unit(expected @ forces), atol=1e-4)
