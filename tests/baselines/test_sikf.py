"""The social induced Kalman filter."""

import math

import numpy as np
import pytest

from baselines.estimators.sikf import SIKFParameters
from baselines.estimators.uncertainty import spectral_norm
from baselines.weighting.sikf import SIKF
from swarm_forage_env.arrays import NEST, PREY
from swarm_forage_env.scenarios import find_scenario

HALF = np.full((2, 2), 0.5, np.float32)


@pytest.fixture
def pair():
    """Two robots of which an exchange just ended."""
    scenario = find_scenario("es1", {"n_robots": 2})
    return SIKFParameters().start(scenario, 1)


def end(estimator, own, heard, goal=NEST):
    """Let an exchange of robot 0 about the nest end, with or without an own estimate."""
    e, b = estimator.encounter, estimator.beliefs
    e.valid[0] = e.heard_known[0, NEST] = True
    e.own_known[0, NEST] = b.known[0, NEST] = own is not None
    b.heard_sum[0, NEST], b.heard_weight[0, NEST], b.heard_p[0, NEST] = (2.0, 4.0), 2.0, heard
    b.goal[0] = goal
    if own is not None:
        estimator.moments[0, NEST] = [own**2, 0.0, 0.25 * own**2, 0.0, 0.1 * own, 0.04]
        b.p[0, NEST] = own


def norm(estimator):
    return spectral_norm(*estimator.moments[0, NEST, :3])


def test_the_gain_compares_variances(encounter):
    g = SIKF()(encounter([0.1, 0.3, 0.0, 0.0], [0.3, 0.1, 0.2, 0.0]))
    assert g[:, NEST] == pytest.approx([0.1, 0.9, 0.0, 0.5])
    assert g.dtype == np.float32


def test_both_robots_end_with_the_same_norm(pair):
    end(pair, own=0.2, heard=0.4)
    g = SIKF()(_seen(pair))
    pair.merge(g, SIKF.heard_p_share)
    expected = 0.2**2 * 0.4**2 / (0.2**2 + 0.4**2)
    assert norm(pair) == pytest.approx(expected)
    assert pair.beliefs.p[0, NEST] == pytest.approx(math.sqrt(expected))


def _seen(estimator):
    e, b = estimator.encounter, estimator.beliefs
    e.own_p[:], e.heard_p[:] = b.p, b.heard_p
    return e


def test_a_goal_that_is_not_headed_for_is_kept(pair):
    end(pair, own=0.2, heard=0.1, goal=PREY)
    pair.merge(HALF, 0.0)
    assert norm(pair) == pytest.approx(0.04)
    assert pair.beliefs.location[0, NEST].tolist() == [0.0, 0.0]


def test_what_was_unknown_is_copied_as_a_circle(pair):
    end(pair, own=None, heard=0.3)
    pair.merge(HALF, 0.0)
    assert pair.moments[0, NEST] == pytest.approx([0.09, 0.0, 0.09, 0.0, 0.0, 0.0])
    assert pair.beliefs.location[0, NEST].tolist() == [1.0, 2.0]
    assert pair.beliefs.p[0, NEST] == 0.3


def test_a_reset_forgets_the_covariances(pair):
    end(pair, own=0.2, heard=0.3)
    pair.reset(0, 0)
    assert not pair.moments.any()
