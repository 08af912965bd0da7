"""Covariance knowledge: whole error ellipses are told, turned and merged."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from baselines.estimators.covariance import blend, gain_matrix
from baselines.estimators.path_covariance import to_ellipse, to_matrix
from swarm_forage_env.arrays import NEST, PREY

SIZES = st.floats(0.01, 3.0)


def covariance(rng, n=2):
    root = rng.normal(size=(n, n))
    return root @ root.T


def flat(P):  # noqa: N803 as in the paper
    return float(P[0, 0]), float(P[0, 1]), float(P[1, 1])


@given(SIZES, SIZES, st.floats(-math.pi, math.pi))
def test_an_ellipse_and_its_matrix_are_the_same(a, b, direction):
    cov = to_matrix(max(a, b), min(a, b), direction)
    assert to_matrix(*to_ellipse(*cov)) == pytest.approx(cov, abs=1e-9)


def test_gain_and_posterior_are_those_of_the_paper_and_the_whole_stays_a_covariance():
    rng = np.random.default_rng(5)
    for _ in range(20):
        P, R = covariance(rng, 3), covariance(rng)  # noqa: N806 as in the paper
        own, found = P[:2, :2], np.array([*flat(P), P[0, 2], P[1, 2], P[2, 2]])
        K = gain_matrix(flat(P), flat(R))  # noqa: N806 as in the paper
        assert_allclose(np.reshape(K, (2, 2)), own @ np.linalg.inv(own + R), atol=1e-9)
        blend(K, found, flat(R))
        assert_allclose(found[:3], flat(R @ np.linalg.inv(own + R) @ own), atol=1e-9)
        xx, xy, yy, xt, yt, tt = found
        whole = np.array([[xx, xy, xt], [xy, yy, yt], [xt, yt, tt]])
        assert np.linalg.eigvalsh(whole).min() > -1e-9
        assert tt == P[2, 2]


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
