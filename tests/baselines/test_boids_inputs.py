"""What the motion of boids is shown of the flock and of the robot itself, worked by hand."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from baselines.estimators import boids_inputs
from baselines.estimators.pose_prediction import PoseMind
from swarm_forage_env.compiler import entry_point
from swarm_forage_env.record import rows
from swarm_forage_env.waypoints.records import Readings, Sighting

describe_flock = entry_point(boids_inputs.describe_flock)
describe_self = entry_point(boids_inputs.describe_self)

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


def unit(v):
    return v / np.hypot(*v)


def test_a_robot_is_shown_its_neighbours_that_it_sees_and_believes_in_reach(flock):
    # BOIDS, Eq. 21 to 23
    seen = flock(authors=0.0)
    assert seen.density == pytest.approx(3 / 5)
    assert_allclose(seen.centre, POSES[1:3].mean(axis=0) - POSES[0], atol=1e-6)
    assert_allclose(seen.separation, (POSES[0] - POSES[1:3]).sum(axis=0), atol=1e-6)
    assert_allclose(seen.alignment, VELOCITIES[1:3].mean(axis=0), atol=1e-6)


def test_the_authors_steer_anew_after_each_neighbour_and_align_with_places(flock):
    seen = flock(authors=1.0, seen=[1, 2])
    ways = POSES[0] - POSES[1:3]
    after_one = unit(MAX_SPEED * unit(ways[0]) - VELOCITIES[0])
    expected = (5.0 * after_one + ways[1] / np.hypot(*ways[1]) ** 2) / 2
    assert_allclose(seen.separation, expected, rtol=1e-5)
    assert_allclose(seen.alignment, POSES[1:3].mean(axis=0), atol=1e-6)


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
