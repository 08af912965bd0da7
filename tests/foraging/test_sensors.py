"""The robot's own sensors: encoders, ground and proximity, on robots put at given places."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from swarm_forage_env.epuck.records import ENCODER, GROUND, PROXIMITY
from swarm_forage_env.equations.proximity import (
    PROXIMITY_ANGLES,
    SENSING_RANGE,
    ray_to_disc,
    ray_to_walls,
    response,
)

DT, AXLE, RADIUS = 0.1, 0.053, 0.035
ARENA = np.array([1.7, 1.2])
FREE = 0.0, 0.0, 0.0
"""Far from all walls, on the floor."""
NEAR = {"area_distance": 0.8}
"""The nest at x = -0.4 m, the prey at 0.4 m."""
RIGHT, LEFT = 2, 5
"""The sensors at -90 and +90 degrees."""

# --- encoders ------------------------------------------------------------------------------------


@pytest.fixture
def odometry(block):
    """Distance and turn that so many robots read at these wheel speeds [m/s]."""

    def read(wheels, noise=0.058, n_worlds=1):
        robots = block([FREE], n_worlds, wheel_noise=noise)
        robots.state.wheels[:] = wheels
        return robots.sense().odometry.astype(float)

    return read


def paths(odometry):
    """Left and right wheel's path [m] out of distance and turn."""
    half = 0.5 * AXLE * odometry[:, 1]
    return odometry[:, 0] - half, odometry[:, 0] + half


@pytest.mark.parametrize("wheels", [(0.06, 0.06), (-0.06, 0.03), (0.0, 0.129)])
def test_exact_encoders_tell_distance_and_turn(odometry, wheels):
    left, right = wheels
    expected = (0.5 * (left + right) * DT, (right - left) * DT / AXLE)
    np.testing.assert_allclose(odometry(wheels, 0.0)[0], expected, rtol=1e-6, atol=1e-9)


def test_a_robot_at_rest_reads_nothing_at_all(odometry):
    assert np.all(odometry((0.0, 0.0), 0.3, n_worlds=50) == 0.0)


def test_the_error_of_a_wheel_is_a_share_of_the_cruise_speeds_path(odometry, believable):
    error = 0.04 * 0.06 * DT
    for wheels in ((0.06, 0.02), (-0.001, 0.129)):
        left, right = paths(odometry(wheels, 0.04, n_worlds=8000))
        for path, speed in ((left, wheels[0]), (right, wheels[1])):
            missed = path - speed * DT
            assert np.abs(missed).max() <= error * (1.0 + 1e-4)
            believable(stats.kstest(missed, stats.uniform(-error, 2.0 * error).cdf).pvalue)


def test_the_errors_of_the_wheels_are_independent(odometry, believable):
    left, right = paths(odometry((0.06, 0.06), 0.04, n_worlds=8000))
    believable(stats.pearsonr(left, right).pvalue)


def test_a_wheel_at_rest_beside_a_turning_one_is_read_exactly(odometry):
    left, right = paths(odometry((0.0, 0.06), 0.04, n_worlds=100))
    assert np.abs(left).max() < 1e-9
    assert np.ptp(right) > 1e-4


# --- ground --------------------------------------------------------------------------------------


@pytest.fixture
def ground(block):
    """Brightness that so many robots read at a place."""

    def read(x, y, theta, noise=0.0, n_worlds=1):
        return block([(x, y, theta)], n_worlds, ground_noise=noise, **NEAR).sense().ground

    return read


def test_the_ground_sensors_look_ahead_of_the_centre(ground):
    assert ground(-0.4 - 0.12, 0.0, 0.0).tolist() == [[0.0, 0.0, 0.0]]
    assert ground(-0.4 - 0.12, 0.0, math.pi).tolist() == [[1.0, 1.0, 1.0]]


def test_left_middle_and_right_are_told_apart(ground):
    # At the rim of the nest, looking along it: the left side looks in, the right side out.
    assert ground(-0.4, 0.1 - 0.002, math.pi)[0].tolist() == [0.0, 1.0, 1.0]
    assert ground(-0.4, 0.1 - 0.002, 0.0)[0].tolist() == [1.0, 1.0, 0.0]


def test_the_floor_is_read_within_three_tenths(ground, believable):
    reading = ground(0.0, 0.0, 0.0, noise=0.3, n_worlds=5000)
    assert reading.min() >= 0.7 - 1e-6
    assert reading.max() <= 1.3 + 1e-6
    believable(stats.kstest(reading.ravel().astype(float), stats.uniform(0.7, 0.6).cdf).pvalue)


def test_the_prey_is_read_within_three_tenths_and_the_nest_exactly(ground):
    prey = ground(0.4, 0.0, 0.0, noise=0.3, n_worlds=2000)
    assert prey.min() >= 0.35 - 1e-6
    assert prey.max() <= 0.65 + 1e-6
    assert np.all(ground(-0.4, 0.0, 0.0, noise=0.3, n_worlds=2000) == 0.0)


# --- proximity -----------------------------------------------------------------------------------


@pytest.fixture
def proximity(block):
    """What robots at these places read."""

    def read(*places, noise=0.0, n_worlds=1):
        return block(places, n_worlds, proximity_noise=noise).sense().proximity

    return read


def test_the_nearest_robot_is_the_one_that_is_seen(proximity):
    seen = proximity(FREE, (0.0, 0.09, 0.0), (0.0, 0.075, 0.0), (0.0, 0.3, 0.0))
    assert seen[0, LEFT] == pytest.approx(response(0.005))
    assert seen[0, RIGHT] == 0.0
    assert seen[2, RIGHT] == pytest.approx(response(0.005))
    assert np.all(seen[3] == 0.0)


@given(
    st.lists(st.tuples(st.floats(-0.1, 0.1), st.floats(-0.1, 0.1), st.floats(-3.0, 3.0)),
             min_size=1, max_size=5),
    st.sampled_from([(0.0, 0.0), (0.75, 0.0), (0.0, -0.5), (-0.75, 0.5)]),
)  # fmt: skip
def test_a_sensor_reads_the_nearest_of_all_robots_and_walls(block, places, corner):
    pose = np.array(places) + np.array([*corner, 0.0])
    pose[:, :2] = np.clip(pose[:, :2], RADIUS - 0.5 * ARENA, 0.5 * ARENA - RADIUS)
    seen = block(pose, proximity_noise=0.0).sense().proximity
    for i, (x, y, theta) in enumerate(pose):
        c, s = math.cos(theta), math.sin(theta)
        for ray, angle in enumerate(PROXIMITY_ANGLES):
            u, v = math.cos(theta + angle), math.sin(theta + angle)
            away = [ray_to_walls(x, y, u, v, ARENA, RADIUS)]
            for dx, dy in np.delete(pose[:, :2], i, axis=0) - (x, y):
                away.append(ray_to_disc(c * dx + s * dy, c * dy - s * dx, ray, RADIUS))
            assert seen[i, ray] == pytest.approx(response(min(away)), abs=1e-6)


def test_in_a_corner_each_sensor_sees_the_nearer_wall(proximity):
    x, y = 0.5 * ARENA - RADIUS - [0.01, 0.03]
    seen = proximity((x, y, 0.0))[0]
    assert seen[LEFT] == pytest.approx(response(0.03))
    assert seen[7] == pytest.approx(response(0.045 / math.cos(math.radians(17.0)) - RADIUS))
    assert seen[6] == pytest.approx(response(0.045 / math.cos(math.radians(50.0)) - RADIUS))


def test_far_from_all_walls_and_robots_nothing_is_seen(block):
    rim = 0.5 * 1.7 - RADIUS - SENSING_RANGE - 1e-9
    robots = block([(0.0, 0.0, 0.3), (rim, 0.0, 0.3)], proximity_noise=0.2)
    before = robots.state.streams.copy()
    assert np.all(robots.sense().proximity == 0.0)
    assert np.array_equal(robots.state.streams[:, PROXIMITY], before[:, PROXIMITY])


def left_readings(proximity, gap, noise, n_worlds=4000):
    """What robots read of another at this gap to their left."""
    return proximity(FREE, (0.0, 2.0 * RADIUS + gap, 0.0), noise=noise, n_worlds=n_worlds)[
        ::2, LEFT
    ]


def test_readings_stay_within_a_fifth_of_the_response(proximity, believable):
    share = left_readings(proximity, 0.02, 0.2) / response(0.02)
    assert share.min() >= 0.8 - 1e-6
    assert share.max() <= 1.2 + 1e-6
    believable(stats.kstest(share.astype(float), stats.uniform(0.8, 0.4).cdf).pvalue)


def test_a_reading_saturates_at_one(proximity):
    reading = left_readings(proximity, 0.0, 0.2)
    assert reading.max() == 1.0
    assert reading.min() >= 0.8
    assert 0.45 < np.mean(reading == 1.0) < 0.55


def test_without_noise_the_reading_is_the_response(proximity):
    readings = left_readings(proximity, 0.02, 0.0, n_worlds=3)
    np.testing.assert_allclose(readings, response(0.02), rtol=1e-6)


def test_each_sensor_draws_from_a_stream_of_its_own_kind(block):
    robots = block([(-0.81, 0.4, 0.0)], proximity_noise=0.2)
    robots.state.wheels[:] = 0.06
    before = robots.state.streams.copy()
    robots.sense()
    moved = np.flatnonzero(robots.state.streams[0] != before[0])
    assert moved.tolist() == [ENCODER, PROXIMITY, GROUND]
