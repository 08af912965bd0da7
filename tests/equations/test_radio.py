"""The range-and-bearing radio: how often a message is lost, and how badly it is measured."""

import math

import numpy as np
import pytest

from swarm_forage_env.equations.radio import (
    POWER_GAP,
    POWER_MU,
    POWER_SIGMA,
    board_range,
    interpolate,
    loss,
    mean_board_range,
    mean_error,
)
from swarm_forage_env.equations.random_draws import normal, symmetric


@pytest.mark.parametrize(
    ("d", "share"), [(0.0, 0.01), (0.01, 0.01), (0.08, 0.255), (0.15, 0.5), (0.2, 0.5)]
)
def test_loss_rises_linearly_from_one_percent_at_a_centimetre_to_half_at_the_end(d, share):
    assert loss(d, 0.01, 0.15, 0.01, 0.5) == pytest.approx(share)


def test_frames_of_the_real_board_are_averaged(fresh):
    alone, together = fresh(1), fresh(1)
    frames = [board_range(0.1, alone, 0) for _ in range(10)]
    assert mean_board_range(0.1, together, 0, 10) == pytest.approx(np.mean(frames))


def test_the_power_of_the_real_board_is_the_published_table():
    # exp(mu), the median power, by the gap between bodies; exp(sigma), by which it scatters.
    gaps = [0.0, 0.02, 0.05, 0.10, 0.15, 0.30, 0.45, 0.60]
    powers = [2094.35, 1992.21, 1408.10, 1193.92, 1079.23, 1009.29, 918.74, 924.27]
    spreads = [1.4290, 1.3758, 1.2129, 1.1653, 1.1152, 1.1298, 1.1653, 1.1526]
    np.testing.assert_allclose(POWER_GAP, gaps)
    np.testing.assert_allclose(np.exp(POWER_MU), powers, rtol=1e-5)
    np.testing.assert_allclose(np.exp(POWER_SIGMA), spreads, rtol=1e-4)


def test_one_frame_of_the_real_board_follows_the_published_formula(fresh):
    words, same = fresh(1), fresh(1)
    for gap, mu, sigma in ((0.02, 7.597, 0.319), (0.075, 7.1675, 0.173), (0.7, 6.829, 0.142)):
        power = math.exp(mu + sigma * normal(same, 0))
        expected = 0.01 * math.exp(9.06422 - 0.00565075 * power)
        assert board_range(gap, words, 0) == pytest.approx(expected)


@pytest.mark.parametrize(("frames", "amplitude"), [(1, 0.5), (4, 3.0)])
def test_an_error_is_the_mean_of_those_of_its_frames(fresh, frames, amplitude):
    words, same = fresh(1), fresh(1)
    expected = amplitude * np.mean([symmetric(same, 0) for _ in range(frames)])
    assert mean_error(words, 0, frames, amplitude) == pytest.approx(expected)


@pytest.mark.parametrize(
    ("x", "y"), [(0.0, 5.0), (1.0, 7.0), (2.0, 3.0), (0.5, 6.0), (1.25, 6.0), (9.0, 3.0)]
)
def test_between_points_lie_straight_lines_and_beyond_them_the_last_value(x, y):
    found = interpolate(x, np.array([0.0, 1.0, 2.0]), np.array([5.0, 7.0, 3.0]))
    assert found == pytest.approx(y)
