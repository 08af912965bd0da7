"""Wheel encoders: the path of the wheels, misread a little."""

import numpy as np
import pytest
from scipy import stats

from swarm_forage_env.kernels.odometry import read_odometry
from swarm_forage_env.streams import Cause, streams

DT, AXLE = 0.1, 0.053


def read(wheels, error, rows=1):
    reading = np.empty((rows, 2), np.float32)
    words = streams([2], rows, Cause.ENCODER)
    read_odometry(np.tile(np.array(wheels, float), (rows, 1)), DT, AXLE, error, words, reading)
    return reading.astype(float)


def paths(reading):
    """Left and right wheel's path [m] out of distance and turn."""
    half = 0.5 * AXLE * reading[:, 1]
    return reading[:, 0] - half, reading[:, 0] + half


@pytest.mark.parametrize("wheels", [(0.06, 0.06), (-0.06, 0.03), (0.0, 0.129)])
def test_exact_encoders_tell_distance_and_turn(wheels):
    left, right = wheels
    expected = (0.5 * (left + right) * DT, (right - left) * DT / AXLE)
    np.testing.assert_allclose(read(wheels, 0.0)[0], expected, rtol=1e-6, atol=1e-9)


def test_a_robot_at_rest_reads_nothing_at_all():
    assert np.all(read((0.0, 0.0), 0.001, rows=50) == 0.0)


def test_the_error_of_a_wheel_is_uniform_whatever_its_speed(believable):
    error = 0.00024
    for wheels in ((0.06, 0.02), (-0.001, 0.129)):
        left, right = paths(read(wheels, error, rows=8000))
        for path, speed in ((left, wheels[0]), (right, wheels[1])):
            missed = path - speed * DT
            assert np.abs(missed).max() <= error * (1.0 + 1e-4)
            believable(stats.kstest(missed, stats.uniform(-error, 2.0 * error).cdf).pvalue)


def test_the_errors_of_the_wheels_are_independent(believable):
    left, right = paths(read((0.06, 0.06), 0.00024, rows=8000))
    believable(stats.pearsonr(left, right).pvalue)


def test_a_wheel_at_rest_beside_a_turning_one_is_read_exactly():
    left, right = paths(read((0.0, 0.06), 0.00024, rows=100))
    assert np.abs(left).max() < 1e-9
    assert np.ptp(right) > 1e-4
