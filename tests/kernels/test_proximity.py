"""Infrared: the published response, and rays to robots and walls."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from swarm_forage_env.kernels.frames import wrap
from swarm_forage_env.kernels.proximity import (
    PROXIMITY_ANGLES,
    SENSING_RANGE,
    ray_to_disc,
    read_proximity,
    response,
    sense_robots,
    sense_walls,
)
from swarm_forage_env.streams import Cause, streams

RADIUS = 0.035
ARENA = np.array([1.7, 1.2])
RIGHT, LEFT = 2, 5
"""The sensors at -90 and +90 degrees."""


def test_the_sensors_look_in_the_published_directions():
    # ARGoS numbers clockwise from the front right: 17, 50, 90, 150, 210, 270, 310, 343 degrees.
    clockwise = np.degrees(-PROXIMITY_ANGLES) % 360.0
    np.testing.assert_allclose(clockwise, [17, 50, 90, 150, 210, 270, 310, 343])


@pytest.mark.parametrize(
    ("d", "reading"),
    [
        (0.0, 1.0),  # the curve starts at 1.08212 and is cut at 1
        (0.01, 0.7430291),
        (0.02, 0.4636784),
        (0.04, 0.0841976),
        (0.05, 0.0),
        (0.0500001, 0.0),
        (0.1, 0.0),
        (math.inf, 0.0),
    ],
)
def test_the_response_is_the_published_curve(d, reading):
    assert response(d) == pytest.approx(reading, abs=1e-9)


@given(st.floats(0.0, 0.2), st.floats(0.0, 0.2))
def test_nearer_never_reads_less(a, b):
    assert 0.0 <= response(max(a, b)) <= response(min(a, b)) <= 1.0


@pytest.mark.parametrize("ray", range(8))
@pytest.mark.parametrize("gap", [0.0, 0.013, 0.05])
def test_a_disc_straight_in_front_of_a_sensor_is_at_its_gap(ray, gap):
    d = 2.0 * RADIUS + gap
    angle = PROXIMITY_ANGLES[ray]
    assert ray_to_disc(d * math.cos(angle), d * math.sin(angle), ray, RADIUS) == pytest.approx(gap)


def test_a_disc_straight_ahead_is_seen_aslant_by_both_front_sensors():
    # Centre at 0.1 m: the ray at 17 degrees leaves 0.1 cos 17 = 0.09563 m along and passes
    # 0.1 sin 17 = 0.02924 m aside; half the chord is sqrt(0.035^2 - 0.02924^2) = 0.01924 m.
    expected = 0.09563048 - 0.01924017 - 0.035
    for ray in (0, 7):
        assert ray_to_disc(0.1, 0.0, ray, RADIUS) == pytest.approx(expected, abs=1e-6)
    for ray in (1, 2, 3, 4, 5, 6):
        assert ray_to_disc(0.1, 0.0, ray, RADIUS) == math.inf


def test_a_disc_behind_or_aside_is_not_seen():
    assert ray_to_disc(0.0, -0.08, LEFT, RADIUS) == math.inf
    assert ray_to_disc(RADIUS + 1e-6, 0.08, LEFT, RADIUS) == math.inf
    assert ray_to_disc(RADIUS - 1e-6, 0.08, LEFT, RADIUS) < math.inf


def test_overlapping_discs_are_at_no_distance():
    assert ray_to_disc(0.0, 0.06, LEFT, RADIUS) == 0.0


def test_the_nearest_robot_is_the_one_that_is_seen():
    pose = np.array([[0.0, 0.0, 0.0], [0.0, 0.09, 0.0], [0.0, 0.075, 0.0], [0.0, 0.3, 0.0]])
    pairs = np.array([[1, 0], [2, 0], [3, 0], [2, 1], [3, 1], [3, 2]], np.int32)
    distance = np.full((4, 8), np.inf)
    sense_robots(pose, pairs, len(pairs), RADIUS, distance)
    assert distance[0, LEFT] == pytest.approx(0.005)
    assert distance[0, RIGHT] == np.inf
    assert distance[2, RIGHT] == pytest.approx(0.005)
    assert np.all(distance[3] == np.inf)


def seen_walls(x, y, theta):
    distance = np.empty((1, 8))
    sense_walls(np.array([[x, y, theta]]), ARENA, RADIUS, distance)
    return distance[0]


@pytest.mark.parametrize("ray", range(8))
@pytest.mark.parametrize("gap", [0.0, 0.02, 0.049])
@pytest.mark.parametrize(
    ("side", "direction"),
    [((1, 0), 0.0), ((0, 1), math.pi / 2), ((-1, 0), math.pi), ((0, -1), -math.pi / 2)],
)
def test_a_wall_on_any_side_is_at_its_gap_for_the_sensor_that_faces_it(ray, gap, side, direction):
    x, y = np.array(side) * (0.5 * ARENA - RADIUS - gap)
    theta = wrap(direction - PROXIMITY_ANGLES[ray])
    distance = seen_walls(x, y, theta)
    assert distance[ray] == pytest.approx(gap, abs=1e-12)
    for other in range(8):  # aslant by the angle between the sensors; the far walls are far
        aslant = math.cos(PROXIMITY_ANGLES[other] - PROXIMITY_ANGLES[ray])
        if aslant > 0.5:
            expected = (gap + RADIUS) / aslant - RADIUS
            assert distance[other] == pytest.approx(expected, abs=1e-9)
        else:
            assert distance[other] > 2.0 * gap


def test_in_a_corner_each_sensor_sees_the_nearer_wall():
    x, y = 0.5 * ARENA - RADIUS - [0.01, 0.03]
    distance = seen_walls(x, y, 0.0)
    assert distance[LEFT] == pytest.approx(0.03)
    assert distance[7] == pytest.approx(0.045 / math.cos(math.radians(17.0)) - RADIUS)
    assert distance[6] == pytest.approx(0.045 / math.cos(math.radians(50.0)) - RADIUS)


def test_far_from_all_walls_nothing_is_seen():
    assert np.all(seen_walls(0.0, 0.0, 0.3) == np.inf)
    assert np.all(seen_walls(0.5 * 1.7 - RADIUS - SENSING_RANGE - 1e-9, 0.0, 0.3) == np.inf)


def readings_at(d, noise, rows=4000):
    reading = np.empty((rows, 8), np.float32)
    words = streams([11], rows, Cause.PROXIMITY)
    read_proximity(np.full((rows, 8), d), noise, words, reading)
    return reading


def test_readings_stay_within_a_fifth_of_the_response(believable):
    truth = response(0.02)
    share = readings_at(0.02, 0.2) / truth
    assert share.min() >= 0.8 - 1e-6
    assert share.max() <= 1.2 + 1e-6
    believable(stats.kstest(share.ravel().astype(float), stats.uniform(0.8, 0.4).cdf).pvalue)


def test_a_reading_saturates_at_one():
    reading = readings_at(0.0, 0.2)
    assert reading.max() == 1.0
    assert reading.min() >= 0.8
    assert 0.45 < np.mean(reading == 1.0) < 0.55


def test_without_noise_the_reading_is_the_response():
    assert np.all(readings_at(0.02, 0.0, rows=3) == np.float32(response(0.02)))


def test_nothing_in_sight_reads_zero():
    assert np.all(readings_at(math.inf, 0.2, rows=3) == 0.0)
