"""The filters of adaptive boids where e-pucks forage."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from baselines.estimators import covariance as ellipses
from baselines.estimators import cross_covariance
from baselines.estimators.covariance import EllipseMind
from baselines.estimators.cross_covariance import CrossBelief, CrossMind, forget_cross_covariances
from swarm_forage_env.arrays import NEST, PREY
from swarm_forage_env.record import rows

A, R = np.array([[0.04, 0.01], [0.01, 0.02]]), np.array([[0.02, -0.005], [-0.005, 0.05]])
OWN, HEARD = np.array([1.0, 0.0]), np.array([1.2, 0.3])
FRAMES = 3.0


def covariance(xx, yy, correlation):
    xy = correlation * np.sqrt(xx * yy)
    return np.array([[xx, xy], [xy, yy]])


VARIANCE = st.floats(0.01, 1.0)
covariances = st.builds(covariance, VARIANCE, VARIANCE, st.floats(-0.9, 0.9))


def one_robot(kind, P, known=True):  # noqa: N803 as in the paper
    """Robot 0 of two, which heads for the prey and knows where it is up to P."""
    mind = rows(kind.array((1,)))[0]
    b, shared = mind.belief, np.zeros((2, 2, 2, 2))
    b.goal, b.last_partner = PREY, 1
    b.known[PREY] = mind.exchange.own_known[PREY] = known
    b.location[PREY] = OWN
    b.moments[PREY, :3] = P[0, 0], P[0, 1], P[1, 1]
    return SimpleNamespace(mind=mind, belief=b, shared=shared)


def tell(s, place, R, g):  # noqa: N803 as in the paper
    """What an exchange of some frames with robot 1 has brought about the prey, and its weight."""
    b, e = s.belief, s.mind.exchange
    b.heard_sum[PREY], b.heard_weight[PREY] = FRAMES * place, FRAMES
    b.heard_cov[PREY] = FRAMES * np.array([R[0, 0], R[0, 1], R[1, 1]])
    e.weight[:] = g


def position(s):
    xx, xy, yy = s.belief.moments[PREY, :3]
    return np.array([[xx, xy], [xy, yy]])


@pytest.fixture(scope="module")
def intersect(numbers_of):
    """Merge what was told by covariance intersection."""
    numbers = numbers_of({"double": 0.0, "intersects": 1.0})

    def merge(s, place, R, g):  # noqa: N803 as in the paper
        tell(s, place, R, g)
        ellipses.merge(s.mind, s.shared, 0.0, numbers)

    return merge


@pytest.fixture(scope="module")
def correct(numbers_of):
    """Merge what was told by the decentralised EKF."""
    numbers = numbers_of({"double": 0.0, "intersects": 0.0})

    def merge(s, place, R, g=0.5):  # noqa: N803 as in the paper
        tell(s, place, R, g)
        cross_covariance.merge(s.mind, s.shared, 0.0, numbers)

    return merge


@given(covariances, covariances, st.sampled_from([0.125, 0.25, 0.5, 0.75]))
def test_intersection_is_the_weighted_mean_of_the_inverses(intersect, own, heard, g):
    s = one_robot(EllipseMind, own)
    intersect(s, HEARD, heard, g)
    inverse = (1 - g) * np.linalg.inv(own) + g * np.linalg.inv(heard)
    P = np.linalg.inv(inverse)  # noqa: N806 as in the paper
    mean = (1 - g) * np.linalg.inv(own) @ OWN + g * np.linalg.inv(heard) @ HEARD
    assert_allclose(position(s), P, rtol=1e-9, atol=1e-12)
    assert_allclose(s.belief.location[PREY], P @ mean, rtol=1e-9)
    assert s.belief.p[PREY] == pytest.approx(np.sqrt(np.linalg.norm(P, 2)))


def test_a_correction_by_an_estimate_that_shares_errors_is_that_of_the_paper(correct):
    s = one_robot(CrossMind, A)
    s.shared = np.zeros((3, 2, 2, 2))
    C = np.array([[0.008, 0.003], [-0.002, 0.006]])  # noqa: N806 as in the paper
    other = np.array([[0.001, -0.004], [0.005, 0.002]])
    s.shared[1, PREY], s.shared[2, PREY] = C, other
    correct(s, HEARD, R)
    K = (A - C) @ np.linalg.inv(A + R - C - C.T)  # noqa: N806 as in the paper
    rest = np.eye(2) - K
    assert_allclose(s.belief.location[PREY], OWN + K @ (HEARD - OWN))
    mixed = rest @ C @ K.T
    assert_allclose(position(s), rest @ A @ rest.T + K @ R @ K.T + mixed + mixed.T)
    assert_allclose(s.shared[1, PREY], C + K @ (R - C))
    assert_allclose(s.shared[2, PREY], rest @ other)
    assert_allclose(s.shared[:, NEST], 0.0)
    assert s.belief.is_shared.astype(bool).tolist() == [False, True]


def test_a_copied_place_shares_all_its_error(correct):
    s = one_robot(CrossMind, A, known=False)
    correct(s, HEARD, R)
    assert_allclose(s.belief.location[PREY], HEARD)
    assert_allclose(position(s), R)
    assert_allclose(s.shared[1, PREY], R)
    assert_allclose(s.shared[0], 0.0)
    assert s.belief.known.astype(bool).tolist() == [False, True]
    assert s.belief.is_shared.astype(bool).tolist() == [False, True]
    assert s.belief.p[PREY] == pytest.approx(np.sqrt(np.linalg.norm(R, 2)))


def test_a_weight_of_zero_leaves_the_estimate_as_it_is(correct):
    s = one_robot(CrossMind, A)
    correct(s, HEARD, R, g=0.0)
    assert_allclose(s.belief.location[PREY], OWN)
    assert_allclose(position(s), A)


@given(st.lists(st.tuples(covariances, st.floats(0.0, 1.0)), min_size=1, max_size=12))
def test_covariances_stay_covariances_under_any_exchanges(correct, exchanges):
    s = one_robot(CrossMind, A)
    for heard, g in exchanges:
        correct(s, HEARD, heard, g)
        low, high = np.linalg.eigvalsh(position(s))
        assert np.isfinite(high)
        assert low >= -1e-9 * high


@pytest.mark.parametrize(
    ("on_area", "known", "kept"),
    [
        (PREY, (True, True), (True, False)),
        (-1, (False, True), (False, True)),
        (-1, (True, True), (True, True)),
    ],
)
def test_an_area_underfoot_or_forgotten_shares_its_error_with_nobody(on_area, known, kept):
    belief, shared = rows(CrossBelief.array((1,)))[0], np.ones((4, 2, 2, 2))
    belief.on_area, belief.known[:], belief.is_shared[:] = on_area, known, True
    forget_cross_covariances(belief, shared)
    for area in (NEST, PREY):
        assert (shared[:, area] == kept[area]).all()
    assert belief.is_shared.astype(bool).tolist() == list(kept)
