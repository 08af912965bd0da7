"""Covariances: how they grow with the path, and how whole ellipses or their norms are merged."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from baselines.estimators.covariance import blend, gain_matrix, to_ellipse, to_matrix
from baselines.estimators.sikf import (
    CovarianceBelief,
    CovarianceMind,
    SIKFParameters,
    add_noise,
    grow_covariances,
    merge,
    propagate,
    spectral_norm,
)
from baselines.weighting.sikf import gain
from swarm_forage_env.arrays import NEST, PREY
from swarm_forage_env.record import rows
from swarm_forage_env.scenarios import find_scenario

SIZES = st.floats(0.01, 3.0)


def covariance(rng, n=2):
    root = rng.normal(size=(n, n))
    return root @ root.T


def flat(P):  # noqa: N803 as in the paper
    return float(P[0, 0]), float(P[0, 1]), float(P[1, 1])


def moments(P):  # noqa: N803 as in the paper
    return np.array([*flat(P), P[0, 2], P[1, 2], P[2, 2]])


def matrix(moments):
    xx, xy, yy, xt, yt, tt = moments
    return np.array([[xx, xy, xt], [xy, yy, yt], [xt, yt, tt]])


@given(SIZES, SIZES, st.floats(-math.pi, math.pi))
def test_an_ellipse_and_its_matrix_are_the_same(a, b, direction):
    cov = to_matrix(max(a, b), min(a, b), direction)
    assert to_matrix(*to_ellipse(*cov)) == pytest.approx(cov, abs=1e-9)


def test_gain_and_posterior_are_those_of_the_paper_and_the_whole_stays_a_covariance():
    rng = np.random.default_rng(5)
    for _ in range(20):
        P, R = covariance(rng, 3), covariance(rng)  # noqa: N806 as in the paper
        own, found = P[:2, :2], moments(P)
        K = gain_matrix(flat(P), flat(R))  # noqa: N806 as in the paper
        assert_allclose(np.reshape(K, (2, 2)), own @ np.linalg.inv(own + R), atol=1e-9)
        blend(K, found, flat(R))
        assert_allclose(found[:3], flat(R @ np.linalg.inv(own + R) @ own), atol=1e-9)
        assert np.linalg.eigvalsh(matrix(found)).min() > -1e-9
        assert found[-1] == P[2, 2]


@pytest.mark.parametrize(("own", "heard", "k"), [(0.0, 0.0, 0.5), (4.0, 0.0, 1.0), (0.0, 4.0, 0.0)])
def test_without_an_inverse_the_norms_are_compared(own, heard, k):
    assert gain_matrix((own, 0.0, 0.0), (heard, 0.0, 0.0)) == (k, 0.0, 0.0, k)


TOLD = (0.04, 0.01, 0.02)


@pytest.fixture
def told(pair):
    """Robot 1 tells robot 0 of the nest over an exact beam; what they believe afterwards."""

    def tell(own):
        two = pair("covariance", wheel_noise=0.0)
        for robot, cov in ((1, TOLD), (0, own)):
            if cov is not None:
                two.know(robot, NEST, -0.4, 0.1, p=to_ellipse(*cov)[0])
                two.beliefs.moments[robot, NEST, :3] = cov
        two.beliefs.came_from[:] = PREY if own else -1, NEST
        turn = two.beliefs.pose[:, 2] - two.pose[:, 2]  # from the world to each own frame
        two.talk()
        return two.beliefs, turn

    return tell


def turned(cov, angle):
    c, s = math.cos(angle), math.sin(angle)
    R = np.array([[c, -s], [s, c]])  # noqa: N806 as in the paper
    xx, xy, yy = cov
    return R @ np.array([[xx, xy], [xy, yy]]) @ R.T


def test_a_copied_ellipse_points_where_the_senders_does(told):
    beliefs, turn = told(None)
    assert beliefs.known[0, NEST]
    expected = turned(TOLD, turn[0] - turn[1])
    assert beliefs.moments[0, NEST, :3] == pytest.approx(flat(expected), rel=1e-5)


def test_two_ellipses_merge_as_the_paper_says(told):
    own = (0.03, -0.01, 0.05)
    beliefs, turn = told(own)
    inverses = [np.linalg.inv(turned(*each)) for each in ((own, 0.0), (TOLD, turn[0] - turn[1]))]
    expected = np.linalg.inv(sum(inverses))
    assert beliefs.moments[0, NEST, :3] == pytest.approx(flat(expected), rel=1e-5)
    assert beliefs.p[0, NEST] == pytest.approx(math.sqrt(np.linalg.norm(expected, 2)))


AXLE = 0.053


@pytest.fixture
def grow(numbers_of):
    """The covariances of a robot grow by a step, with this error constant."""

    def step(belief, odometry, k):
        numbers = numbers_of({"axle": AXLE, "error_constant": k})
        grow_covariances(belief, np.array(odometry, np.float32), numbers)

    return step


def nobody():
    """What a robot believes that has not moved."""
    return rows(CovarianceBelief.array((1,)))[0]


@pytest.mark.parametrize(("drho", "zeta"), [(0.01, 0.3), (-0.02, 2.0), (0.0, -1.0)])
def test_a_step_is_that_of_the_matrices_of_the_paper(drho, zeta):
    before, q = covariance(np.random.default_rng(1), 3), np.diag([2e-4, 3e-4])
    c, s = math.cos(zeta), math.sin(zeta)
    e = drho / (2.0 * AXLE)
    A = np.array([[1, 0, -drho * s], [0, 1, drho * c], [0, 0, 1]])  # noqa: N806 as in the paper
    W = np.array(  # noqa: N806 as in the paper
        [[c / 2 - e * s, c / 2 + e * s], [s / 2 + e * c, s / 2 - e * c], [1 / AXLE, -1 / AXLE]]
    )
    found = moments(before)
    propagate(found, drho, zeta)
    add_noise(found, drho, zeta, q[0, 0], q[1, 1], AXLE)
    assert_allclose(matrix(found), A @ before @ A.T + W @ q @ W.T, rtol=1e-12, atol=1e-15)


def test_p_is_the_deviation_along_the_worst_axis_and_noise_grows_with_the_path(grow):
    k, belief, expected = 1e-4, nobody(), np.zeros(6)
    belief.pose[2] = 0.3
    grow(belief, (0.01, 0.3), k)
    left, right = 0.01 - 0.15 * AXLE, 0.01 + 0.15 * AXLE
    add_noise(expected, 0.01, 0.15, k * abs(right), k * abs(left), AXLE)
    assert belief.p[0] == pytest.approx(math.sqrt(spectral_norm(*belief.moments[0, :3])))
    assert_allclose(belief.moments[0], expected, rtol=1e-5)


def test_nothing_is_uncertain_on_the_area(grow):
    belief = nobody()
    belief.moments[:], belief.p[:], belief.on_area = 1.0, 1.0, NEST
    grow(belief, (0.01, 0.01), 1e-5)
    assert (belief.moments[NEST] == 0.0).all()
    assert belief.p[NEST] == 0.0
    assert belief.p[PREY] > 1.0


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
