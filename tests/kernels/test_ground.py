"""The floor and what the three sensors read of it."""

import math

import numpy as np
import pytest
from scipy import stats

from swarm_forage_env.arrays import NEST, PREY
from swarm_forage_env.kernels.ground import FLOOR, area_at, brightness, read_ground
from swarm_forage_env.streams import Cause, streams

AREAS = np.array([[-0.4, 0.0], [0.4, 0.0]])
AHEAD, ASIDE = 0.03, 0.009


@pytest.mark.parametrize(
    ("x", "y", "area"),
    [
        (-0.4, 0.0, NEST),
        (0.4, 0.0, PREY),
        (-0.4, 0.0999, NEST),
        (-0.4, 0.1001, FLOOR),
        (0.32, 0.05, PREY),
        (0.0, 0.0, FLOOR),
        (0.4, 0.5, FLOOR),
    ],
)
def test_a_point_lies_in_nest_prey_or_neither(x, y, area):
    assert area_at(x, y, AREAS, 0.1) == area


def test_the_nest_is_black_the_prey_grey_and_the_floor_white():
    assert (brightness(NEST), brightness(PREY), brightness(FLOOR)) == (0.0, 0.5, 1.0)


def read(x, y, theta, noise=0.0, rows=1):
    reading = np.empty((rows, 3), np.float32)
    pose = np.tile([x, y, theta], (rows, 1))
    words = streams([5], rows, Cause.GROUND)
    read_ground(pose, AREAS, 0.1, AHEAD, ASIDE, noise, words, reading)
    return reading


def test_the_sensors_look_ahead_of_the_centre():
    assert read(-0.4 - 0.12, 0.0, 0.0).tolist() == [[0.0, 0.0, 0.0]]
    assert read(-0.4 - 0.12, 0.0, math.pi).tolist() == [[1.0, 1.0, 1.0]]


def test_left_middle_and_right_are_told_apart():
    # At the rim of the nest, looking along it: the left side looks in, the right side out.
    assert read(-0.4, 0.1 - 0.002, math.pi, 0.0)[0].tolist() == [0.0, 1.0, 1.0]
    assert read(-0.4, 0.1 - 0.002, 0.0, 0.0)[0].tolist() == [1.0, 1.0, 0.0]


def test_the_floor_is_read_within_three_tenths(believable):
    reading = read(0.0, 0.0, 0.0, noise=0.3, rows=5000)
    assert reading.min() >= 0.7 - 1e-6
    assert reading.max() <= 1.3 + 1e-6
    believable(stats.kstest(reading.ravel().astype(float), stats.uniform(0.7, 0.6).cdf).pvalue)


def test_the_prey_is_read_within_three_tenths_and_the_nest_exactly():
    prey = read(0.4, 0.0, 0.0, noise=0.3, rows=2000)
    assert prey.min() >= 0.35 - 1e-6
    assert prey.max() <= 0.65 + 1e-6
    assert np.all(read(-0.4, 0.0, 0.0, noise=0.3, rows=2000) == 0.0)
