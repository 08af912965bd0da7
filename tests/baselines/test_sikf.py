"""The social induced Kalman filter."""

import math

import numpy as np
import pytest

from baselines.estimators.path_covariance import CovarianceMind, spectral_norm
from baselines.estimators.sikf import SIKFParameters, merge
from baselines.weighting.sikf import gain
from swarm_forage_env.arrays import NEST, PREY
from swarm_forage_env.record import rows
from swarm_forage_env.scenarios import find_scenario


@pytest.fixture
def ended(numbers_of):
    """What a robot believes after an exchange about the nest, and the gain of its rule."""
    numbers = numbers_of(SIKFParameters().numbers(find_scenario("es1")))

    def end(own, heard, goal=NEST):
        mind = rows(CovarianceMind.array((1,)))[0]
        b, e = mind.belief, mind.exchange
        b.heard_sum[NEST], b.heard_weight[NEST], b.heard_p[NEST] = (2.0, 4.0), 2.0, heard
        b.goal = goal
        b.known[NEST] = e.own_known[NEST] = own is not None
        e.heard_known[NEST], e.heard_p[NEST] = True, heard
        if own is not None:
            b.moments[NEST] = [own**2, 0.0, 0.25 * own**2, 0.0, 0.1 * own, 0.04]
            b.p[NEST] = e.own_p[NEST] = own
        e.weight[:] = g = gain(e, NEST, numbers)
        merge(mind, np.zeros(0), 0.0, numbers)
        return b, g

    return end


@pytest.mark.parametrize(
    ("own", "heard", "expected"),
    [(0.1, 0.3, 0.1), (0.3, 0.1, 0.9), (0.0, 0.2, 0.0), (0.0, 0.0, 0.5)],
)
def test_the_gain_compares_variances_and_both_robots_end_with_the_same_norm(
    ended, own, heard, expected
):
    belief, g = ended(own, heard)
    assert g == pytest.approx(expected)
    norm = 0.0 if own == 0.0 else own**2 * heard**2 / (own**2 + heard**2)
    assert spectral_norm(*belief.moments[NEST, :3]) == pytest.approx(norm)
    assert belief.p[NEST] == pytest.approx(math.sqrt(norm))


def test_a_goal_that_is_not_headed_for_is_kept(ended):
    belief, _ = ended(own=0.2, heard=0.1, goal=PREY)
    assert spectral_norm(*belief.moments[NEST, :3]) == pytest.approx(0.04)
    assert belief.location[NEST].tolist() == [0.0, 0.0]


def test_what_was_unknown_is_copied_as_a_circle(ended):
    belief, _ = ended(own=None, heard=0.3)
    assert belief.moments[NEST] == pytest.approx([0.09, 0.0, 0.09, 0.0, 0.0, 0.0])
    assert belief.location[NEST].tolist() == [1.0, 2.0]
    assert belief.p[NEST] == 0.3
