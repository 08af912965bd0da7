"""How the covariance of a pose grows with the path."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

from baselines.estimators.path_covariance import (
    CovarianceBelief,
    add_noise,
    grow_covariances,
    propagate,
    spectral_norm,
)
from swarm_forage_env.arrays import NEST, PREY
from swarm_forage_env.record import rows

AXLE = 0.053
PLACE = ([0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2])


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


def matrix(moments):
    xx, xy, yy, xt, yt, tt = moments
    return np.array([[xx, xy, xt], [xy, yy, yt], [xt, yt, tt]])


def moments(covariance):
    return np.array([covariance[i, j] for i, j in zip(*PLACE, strict=True)])


@pytest.mark.parametrize(("drho", "zeta"), [(0.01, 0.3), (-0.02, 2.0), (0.0, -1.0)])
def test_a_step_is_that_of_the_matrices_of_the_paper(drho, zeta):
    root = np.random.default_rng(1).normal(size=(3, 3))
    before, q = root @ root.T, np.diag([2e-4, 3e-4])
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


def test_the_norm_is_the_largest_eigenvalue():
    for root in np.random.default_rng(3).normal(size=(20, 2, 2)):
        P = root @ root.T  # noqa: N806 as in the paper
        assert spectral_norm(P[0, 0], P[0, 1], P[1, 1]) == pytest.approx(np.linalg.norm(P, 2))


def test_nothing_is_uncertain_on_the_area(grow):
    belief = nobody()
    belief.moments[:], belief.p[:], belief.on_area = 1.0, 1.0, NEST
    grow(belief, (0.01, 0.01), 1e-5)
    assert (belief.moments[NEST] == 0.0).all()
    assert belief.p[NEST] == 0.0
    assert belief.p[PREY] > 1.0
