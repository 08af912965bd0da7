"""The filters of adaptive boids where e-pucks forage."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from baselines.estimators.arena import Correlated, Intersection, start_in_arena
from baselines.estimators.correlations import forget_correlations, merge_correlated
from baselines.estimators.ellipses import merge_ellipses
from baselines.estimators.localisation import LocalisationParameters
from baselines.estimators.sikf import Uncertain
from baselines.estimators.social_odometry import SocialOdometry
from baselines.weighting.covariance import Covariance
from baselines.weighting.sgikf import SGIKF
from baselines.weighting.sikf import SIKF
from swarm_forage_env.arrays import NEST, PREY
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.scenarios import find_scenario

KINDS = {
    "social_odometry": (SocialOdometry, SGIKF),
    "dead_reckoning": (Uncertain, SGIKF),
    "covariance_intersection": (Intersection, SIKF),
    "decentralised_ekf": (Correlated, Covariance),
}

A, R = np.array([[0.04, 0.01], [0.01, 0.02]]), np.array([[0.02, -0.005], [-0.005, 0.05]])
OWN, HEARD = np.array([1.0, 0.0]), np.array([1.2, 0.3])


def covariance(xx, yy, correlation):
    xy = correlation * np.sqrt(xx * yy)
    return np.array([[xx, xy], [xy, yy]])


VARIANCE = st.floats(0.01, 1.0)
covariances = st.builds(covariance, VARIANCE, VARIANCE, st.floats(-0.9, 0.9))


def test_a_setting_of_the_waypoints_is_refused_where_robots_forage():
    with pytest.raises(ConfigError, match="of robots that visit waypoints, not of es1"):
        LocalisationParameters(setting="authors").start(find_scenario("es1"), 1)


def one_robot(P, known=True):  # noqa: N803 as in the paper
    """The arrays of robot 0 of two, which knows where the prey is up to P."""
    s = {
        "location": np.zeros((1, 2, 2)), "p": np.zeros((1, 2)),
        "known": np.array([[False, known]]), "moments": np.zeros((1, 2, 6)),
        "correlations": np.zeros((1, 2, 2, 2, 2)),
    }  # fmt: skip
    s["location"][0, PREY] = OWN
    s["moments"][0, PREY, :3] = P[0, 0], P[0, 1], P[1, 1]
    return s


def told(place, R, frames=3.0):  # noqa: N803 as in the paper
    """What a conversation of some frames has brought about the prey."""
    sums, weight, cov = np.zeros((1, 2, 2)), np.zeros((1, 2)), np.zeros((1, 2, 3))
    sums[0, PREY], weight[0, PREY] = frames * place, frames
    cov[0, PREY] = frames * np.array([R[0, 0], R[0, 1], R[1, 1]])
    return sums, weight, cov


def position(s):
    xx, xy, yy = s["moments"][0, PREY, :3]
    return np.array([[xx, xy], [xy, yy]])


def intersect(s, place, R, g):  # noqa: N803 as in the paper
    weights, goal = np.full((1, 2), g, np.float32), np.array([PREY], np.int8)
    merge_ellipses(
        np.array([True]), weights, False, True, goal, *told(place, R),
        s["location"], s["p"], s["known"], s["moments"],
    )  # fmt: skip


def correct(s, place, R, g=0.5):  # noqa: N803 as in the paper
    weights, goal = np.full((1, 2), g, np.float32), np.array([PREY], np.int8)
    merge_correlated(
        np.array([True]), weights, False, np.array([1], np.int32), goal, *told(place, R),
        s["location"], s["p"], s["known"], s["moments"], s["correlations"],
    )  # fmt: skip


@given(covariances, covariances, st.sampled_from([0.125, 0.25, 0.5, 0.75]))
def test_intersection_is_the_weighted_mean_of_the_inverses(own, heard, g):
    s = one_robot(own)
    intersect(s, HEARD, heard, g)
    inverse = (1 - g) * np.linalg.inv(own) + g * np.linalg.inv(heard)
    P = np.linalg.inv(inverse)  # noqa: N806 as in the paper
    mean = (1 - g) * np.linalg.inv(own) @ OWN + g * np.linalg.inv(heard) @ HEARD
    assert_allclose(position(s), P, rtol=1e-9, atol=1e-12)
    assert_allclose(s["location"][0, PREY], P @ mean, rtol=1e-9)
    assert s["p"][0, PREY] == pytest.approx(np.sqrt(np.linalg.norm(P, 2)))


def test_the_weight_of_the_fast_form_for_circles_is_that_of_sikf():
    own, heard = 0.3**2 * np.eye(2), 0.5**2 * np.eye(2)
    S = np.linalg.inv(own) + np.linalg.inv(heard)  # noqa: N806 as in the paper
    det = np.linalg.det
    g = (det(S) - det(np.linalg.inv(own)) + det(np.linalg.inv(heard))) / (2 * det(S))
    assert g == pytest.approx(0.3**2 / (0.3**2 + 0.5**2))


def test_without_shared_errors_the_filter_is_a_kalman_filter():
    s = one_robot(A)
    correct(s, HEARD, R)
    K = A @ np.linalg.inv(A + R)  # noqa: N806 as in the paper
    assert_allclose(s["location"][0, PREY], OWN + K @ (HEARD - OWN))
    assert_allclose(position(s), (np.eye(2) - K) @ A)
    assert_allclose(s["correlations"][0, 1, PREY], K @ R)
    assert_allclose(s["correlations"][0, 0], 0.0)


def test_what_was_told_once_is_not_learned_twice():
    s = one_robot(A)
    correct(s, HEARD, R)
    once = {name: array.copy() for name, array in s.items()}
    correct(s, HEARD, R)
    assert np.linalg.norm(position(s)) > 0.95 * np.linalg.norm(position(once))
    assert_allclose(s["location"], once["location"], atol=0.02)
    naive = one_robot(position(once))
    correct(naive, HEARD, R)
    assert np.linalg.norm(position(naive)) < 0.8 * np.linalg.norm(position(once))


def test_a_copied_place_shares_all_its_error():
    s = one_robot(A, known=False)
    correct(s, HEARD, R)
    assert_allclose(s["location"][0, PREY], HEARD)
    assert_allclose(position(s), R)
    assert_allclose(s["correlations"][0, 1, PREY], R)


def test_a_weight_of_zero_leaves_the_estimate_as_it_is():
    s = one_robot(A)
    correct(s, HEARD, R, g=0.0)
    assert_allclose(s["location"][0, PREY], OWN)
    assert_allclose(position(s), A)


@given(st.lists(st.tuples(covariances, st.floats(0.0, 1.0)), min_size=1, max_size=12))
def test_covariances_stay_covariances_under_any_exchanges(exchanges):
    s = one_robot(A)
    for heard, g in exchanges:
        correct(s, HEARD, heard, g)
        low, high = np.linalg.eigvalsh(position(s))
        assert np.isfinite(high)
        assert low >= -1e-9 * high


def test_an_area_underfoot_or_forgotten_shares_its_error_with_nobody():
    shared = np.ones((3, 4, 2, 2, 2))
    on_area = np.array([PREY, -1, -1], np.int8)
    known = np.array([[True, True], [False, True], [True, True]])
    forget_correlations(on_area, known, shared)
    assert not shared[0, :, PREY].any()
    assert not shared[1, :, NEST].any()
    assert shared[0, :, NEST].all()
    assert shared[1, :, PREY].all()
    assert shared[2].all()


@pytest.mark.parametrize("kind", KINDS)
def test_every_filter_has_a_rule_of_its_own(kind):
    made, rule = KINDS[kind]
    estimator = start_in_arena(kind, find_scenario("es1"), 2)
    assert type(estimator) is made
    assert type(estimator.own_rule) is rule
    assert estimator.parameters.speaks == (kind != "dead_reckoning")
