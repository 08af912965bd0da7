"""Contacts of two discs, and of a disc with the walls."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from swarm_forage_env.equations.contacts import HALF, keep_inside, separate_pair

RADIUS = 0.035
APART = 2.0 * RADIUS
ARENA = np.array([1.7, 1.2])
PLACES = st.floats(-1.0, 1.0)


def pose(x, y):
    return np.array([x, y, 0.5])


def test_two_discs_part_along_the_line_between_them_each_by_half():
    a, b = pose(0.0, 0.0), pose(0.03, 0.04)
    assert separate_pair(a, b, APART, HALF) == pytest.approx(0.02)
    np.testing.assert_allclose(a, [-0.006, -0.008, 0.5], atol=1e-12)
    np.testing.assert_allclose(b, [0.036, 0.048, 0.5], atol=1e-12)


def test_a_larger_share_moves_each_disc_farther():
    a, b = pose(0.0, 0.0), pose(0.05, 0.0)
    assert separate_pair(a, b, APART, 0.9) == pytest.approx(0.02)
    assert b[0] - a[0] == pytest.approx(0.05 + 2.0 * 0.9 * 0.02)


def test_two_discs_in_one_place_part_along_the_long_side():
    a, b = pose(0.1, 0.1), pose(0.1, 0.1)
    assert separate_pair(a, b, APART, HALF) == pytest.approx(APART)
    np.testing.assert_allclose([a[0], b[0]], [0.065, 0.135], atol=1e-12)
    np.testing.assert_allclose([a[1], b[1]], 0.1, atol=1e-12)


@given(PLACES, PLACES, PLACES, PLACES)
def test_two_discs_end_no_closer_than_they_may_and_others_stay(ax, ay, bx, by):
    a, b = pose(ax, ay), pose(bx, by)
    distance = math.hypot(bx - ax, by - ay)
    short = separate_pair(a, b, APART, HALF)
    assert short == pytest.approx(max(APART - distance, 0.0), abs=1e-12)
    if short == 0.0:
        assert a.tolist() == pose(ax, ay).tolist()
        assert b.tolist() == pose(bx, by).tolist()
    else:
        assert math.hypot(*(b - a)[:2]) == pytest.approx(APART)
        np.testing.assert_allclose(a + b, pose(ax, ay) + pose(bx, by), atol=1e-12)


@given(PLACES, PLACES)
def test_a_disc_in_or_beyond_a_wall_is_put_back_inside_and_others_stay(x, y):
    at = pose(x, y)
    keep_inside(at, ARENA, RADIUS)
    limit = 0.5 * ARENA - RADIUS
    assert at.tolist() == [*np.clip([x, y], -limit, limit), 0.5]
