"""Boids: gains worked by hand, what they weigh, and what a robot sees of its flock."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from pydantic import ValidationError

from baselines.estimators import localisation
from baselines.estimators.pose_prediction import PoseMind
from baselines.motion import boids
from baselines.motion.boids import ALIGN, COHERE, GOAL, HOME, SEPARATE, adaptive_gains
from swarm_forage_env.arrays import NEST, PREY
from swarm_forage_env.compiler import entry_point
from swarm_forage_env.epuck import records as epuck
from swarm_forage_env.foraging.records import Situation as Foraging
from swarm_forage_env.record import rows
from swarm_forage_env.scenarios import find_scenario
from swarm_forage_env.waypoints.records import Readings, Sighting, Situation

SCENARIO = find_scenario("waypoints-05")
RULES = ("alignment", "separation", "centre", "home", "goal")
VECTORS = (*RULES, "velocity")
STIMULI = ("density", "covariance_norm", "dead_reckoning_offset")


def anywhere(seed, has_arrived):
    """The situation of a robot, drawn."""
    rng, (found,) = np.random.default_rng(seed), rows(Situation.array((1,)))
    for name in VECTORS:
        found[name] = rng.normal(size=2)
    for name in STIMULI:
        found[name] = rng.uniform(0.0, 1.5)
    found.velocity *= 0.3
    found.has_arrived = has_arrived
    return found


@pytest.fixture(scope="module")
def pull(numbers_of):
    """The acceleration that boids command in a situation."""

    def steer(seen, **parameters):
        layer = boids.BoidsParameters(**parameters).layer(SCENARIO)
        memory, readings = (rows(kind.array((1,)))[0] for kind in (layer.memory, Readings))
        found = np.full(2, 9.0, np.float32)
        layer.steer(seen, readings, found, memory, numbers_of(layer.numbers))
        return found

    return steer


def unit(v):
    size = np.linalg.norm(v)
    return v / size if size > 0.0 else np.zeros(2)


def total(s, gains):
    """The weighted sum of all forces on one robot."""
    forces = np.zeros(2)
    for gain, name in zip(gains, RULES, strict=True):
        way = s[name].astype(float)
        if way.any() and not (name == "goal" and s.has_arrived):
            forces += gain * unit(0.5 * unit(way) - s.velocity)
    return forces


def adapted(s):
    """The gains of a situation; the distances to goal and home are shares of the side."""
    distances = [np.linalg.norm(way) / SCENARIO.task.side for way in (s.goal, s.home)]
    return gains_of(*(s[name] for name in STIMULI), *distances)


def gains_of(*stimuli):
    gains = np.full(5, 9.0)
    adaptive_gains(*stimuli, gains)
    return gains


@pytest.mark.parametrize(
    ("stimuli", "gains"),
    [
        ((0.0, 0.0, 0.0, 0.0, 0.0), (1.0, 3.0, 0.0, 1.0, 3.0)),
        ((0.2, 0.4, 0.1, 0.3, 0.25), (1.05, 2.2, 0.75, 1.25, 2.2)),
        ((1.0, 1.0, 1.0, 1.0, 1.0), (2.0, 0.0, 3.0, 2.0, 0.0)),
        ((0.0, 3.0, 0.5, 0.5, 0.0), (1.5, -1.0, 3.5, 4.5, -1.0)),
    ],
)
def test_adaptive_gains_are_those_of_the_paper_and_are_not_clamped(stimuli, gains):
    assert_allclose(gains_of(*stimuli), gains, atol=1e-12)


@pytest.mark.parametrize(
    "wrong", [{"gains": "best"}, {"alignment": -0.1}, {"cohesion": 1e300}, {"homming": 1.0}]
)
def test_gains_that_make_no_sense_are_refused(wrong):
    with pytest.raises(ValidationError):
        boids.BoidsParameters(**wrong)


STATIC = {"alignment": 0.3, "separation": 0.5, "cohesion": 0.7, "homing": 1.1, "seeking": 1.3}


@pytest.mark.parametrize("gains", ["goal", "static", "adaptive"])
@pytest.mark.parametrize("seed", range(20))
def test_gains_weigh_the_rules_and_who_has_arrived_ignores_its_goal(pull, seed, gains):
    s = anywhere(seed, has_arrived=seed % 4 == 0)
    weighed = {"goal": (0, 0, 0, 0, 1), "static": STATIC.values(), "adaptive": adapted(s)}[gains]
    assert_allclose(pull(s, gains=gains, **STATIC), unit(total(s, weighed)), atol=1e-5)


describe_flock = entry_point(localisation.describe_flock)
describe_self = entry_point(localisation.describe_self)

REACH, MAX_SPEED, COMPASS = 1.5, 0.5, 0.7
POSES = np.array([[0.3, -0.2], [0.9, 0.6], [-0.1, 0.5], [0.4, 3.0], [0.2, 0.1]])
VELOCITIES = np.array([[0.1, -0.3], [0.2, 0.1], [-0.4, 0.3], [0.5, 0.5], [0.3, 0.2]])
SEEN = [1, 2, 3]
"""By robot 0: two in reach, and one that is believed to be beyond it; the last one is unseen."""


@pytest.fixture
def flock(numbers_of):
    """What robot 0 is shown of four others, in the world frame."""

    def shown(authors, seen=SEEN):
        crowd = rows(PoseMind.array((5,)))
        crowd.belief.pose[:, :2], crowd.belief.velocity[:] = POSES, VELOCITIES
        crowd.compass[:] = COMPASS
        sightings = rows(Sighting.array((25,))).reshape(5, 5)
        sightings.seen[0, seen] = True
        numbers = numbers_of({"authors": authors, "reach": REACH, "max_speed": MAX_SPEED})
        describe_flock(crowd, 0, sightings, numbers)
        found = crowd[0].situation
        vectors = {name: outer(found[name]) for name in ("centre", "separation", "alignment")}
        return SimpleNamespace(density=found.density, **vectors)

    return shown


def outer(v):
    """A vector of the body frame in the world frame."""
    c, s = math.cos(COMPASS), math.sin(COMPASS)
    return np.array([c * v[0] - s * v[1], s * v[0] + c * v[1]])


def test_a_robot_is_shown_its_neighbours_that_it_sees_and_believes_in_reach(flock):
    # BOIDS, Eq. 21 to 23
    seen = flock(authors=0.0)
    assert seen.density == pytest.approx(3 / 5)
    assert_allclose(seen.centre, POSES[1:3].mean(axis=0) - POSES[0], atol=1e-6)
    assert_allclose(seen.separation, (POSES[0] - POSES[1:3]).sum(axis=0), atol=1e-6)
    assert_allclose(seen.alignment, VELOCITIES[1:3].mean(axis=0), atol=1e-6)


@pytest.mark.parametrize("authors", [0.0, 1.0])
def test_with_nobody_in_reach_there_is_no_flock(flock, authors):
    seen = flock(authors, seen=[3])
    assert seen.density == pytest.approx(1 / 5)
    for name in ("centre", "separation", "alignment"):
        assert_allclose(getattr(seen, name), 0.0)


@pytest.mark.parametrize(("tolerance", "has_arrived"), [(5.0, False), (5.001, True)])
def test_a_robot_is_shown_its_goal_home_velocity_and_stimuli(numbers_of, tolerance, has_arrived):
    mind, readings = (rows(kind.array((1,)))[0] for kind in (PoseMind, Readings))
    mind.belief.pose[:], mind.belief.velocity[:] = (1.0, -2.0, 0.3), (0.2, 0.4)
    mind.reckoned.pose[:], mind.compass, mind.covariance_norm = (1.9, -0.8, 0.0), COMPASS, 0.6
    readings.goal[:] = 4.0, 2.0
    numbers = {"covariance_norm_max": 4.0, "offset_max": 3.0, "tolerance": tolerance}
    describe_self(mind, readings, numbers_of(numbers))
    found = mind.situation
    for name, expected in (("goal", (3.0, 4.0)), ("home", (-1.0, 2.0)), ("velocity", (0.2, 0.4))):
        assert_allclose(outer(found[name]), expected, atol=1e-6)
    assert found.covariance_norm == pytest.approx(0.15)
    assert found.dead_reckoning_offset == pytest.approx(0.5)
    assert found.has_arrived == has_arrived


ES1 = find_scenario("es1")
SPEED, SIDE = ES1.robot.cruise_speed, max(ES1.arena.length, ES1.arena.width)
BEAMS = np.array([(0.1, 0.5, -2.0), (0.06, -1.0, 0.3)])
"""Range and bearings of the two robots that are heard."""

WHEELS = np.array([0.4, 0.8], np.float32)


@pytest.fixture(scope="module")
def foraging(numbers_of):
    """What a robot sees that knows both areas and heads for the prey; by what it is steered."""

    def steer(seed, **parameters):
        numbers = numbers_of(boids.BoidsParameters(**parameters).layer(ES1).numbers)
        rng, heard = np.random.default_rng(seed), rows(epuck.Heard.array((1,), slots=4))[0]
        seen, readings, course = (
            rows(kind.array((1,)))[0] for kind in (Foraging, epuck.Readings, boids.FlockCourse)
        )
        seen.areas[:], seen.p[:] = rng.normal(size=(2, 2)), rng.uniform(0.0, 15.0, 2)
        seen.target[:], seen.known[:], seen.goal[:] = seen.areas[PREY], True, np.eye(3)[PREY]
        heard.n, heard.range_bearing[:2] = 2, BEAMS
        boids.steer_epuck(seen, readings, heard, WHEELS.copy(), course, numbers)
        return seen, course

    return steer


def direction(angle):
    return np.array([math.cos(angle), math.sin(angle)])


def test_neighbours_are_where_their_beams_come_from_and_go_where_the_bearings_say(foraging):
    seen, course = foraging(0)
    places = np.array([r * direction(b) for r, b, _ in BEAMS])
    headings = np.array([direction(b + math.pi - back) for _, b, back in BEAMS])
    assert_allclose(course.ways[ALIGN], headings.mean(axis=0), atol=1e-6)
    assert_allclose(course.ways[SEPARATE], -places.sum(axis=0), atol=1e-6)
    assert_allclose(course.ways[COHERE], places.mean(axis=0), atol=1e-6)
    assert_array_equal(course.ways[HOME], seen.areas[NEST])
    assert_array_equal(course.ways[GOAL], seen.target)


@pytest.mark.parametrize("gains", ["goal", "static", "adaptive"])
@given(seed=st.integers(0, 2**32))
def test_the_rules_sum_up_to_the_pull(foraging, gains, seed):
    seen, course = foraging(seed, gains=gains, alignment=0.3, seeking=1.3)
    expected = np.array([0.3, 1.0, 1.0, 1.0, 1.3]) if gains == "static" else np.eye(5)[GOAL]
    if gains == "adaptive":
        far = np.linalg.norm(seen.areas.astype(float), axis=1) / SIDE
        p = seen.p[PREY] / boids.BoidsParameters().trust
        adaptive_gains(2 / ES1.task.n_robots, p, 0.0, far[PREY], far[NEST], expected)
    velocity = np.array([SPEED * WHEELS.mean(), 0.0])
    forces = [unit(SPEED * unit(way.astype(float)) - velocity) for way in course.ways]
    assert_allclose(course.gains, expected, rtol=1e-5)
    assert_allclose(course.pull, unit(expected @ forces), atol=1e-4)
