"""How the covariance of a pose grows with the path."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

from baselines.estimators.path_covariance import (
    CovarianceBelief,
    add_noise,
    error_constant,
    grow_covariances,
    propagate,
    spectral_norm,
)
from swarm_forage_env.arrays import NEST, PREY
from swarm_forage_env.equations.differential_drive import advance, wheels_to_arc
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


def test_the_covariance_is_that_of_many_noisy_walks(grow):
    ticks, walks, error = 60, 4000, 1e-4
    rng = np.random.default_rng(2)
    right, left = np.full(ticks, 0.004), np.full(ticks, 0.0039)
    k = error**2 / 3.0 / 0.00395
    odometry = np.array([wheels_to_arc(*u, AXLE) for u in zip(left, right, strict=True)])
    belief = nobody()
    for step in odometry:
        belief.pose[:] = advance(*belief.pose, *step)
        grow(belief, step, k)
    found = matrix(belief.moments[0])
    ends = np.zeros((walks, 3))
    for walk in range(walks):
        noise = rng.uniform(-error, error, size=(ticks, 2))
        pose = (0.0, 0.0, 0.0)
        for step in range(ticks):
            arc = wheels_to_arc(left[step] + noise[step, 0], right[step] + noise[step, 1], AXLE)
            pose = advance(*pose, *arc)
        ends[walk] = pose
    scale = np.sqrt(np.diag(found))
    sampled = np.cov(ends.T) / np.outer(scale, scale)
    assert_allclose(found / np.outer(scale, scale), sampled, atol=0.1)
    worst = math.sqrt(np.linalg.eigvalsh(np.cov(ends.T)[:2, :2])[1])
    assert belief.p[0] == pytest.approx(worst, 0.05)


def test_the_error_constant_matches_the_encoders_at_the_cruise_speed():
    step = 0.04 * 0.1
    k = error_constant(wheel_noise=0.07, cruise_speed=0.04, tick=0.1)
    assert k * step == pytest.approx((0.07 * step) ** 2 / 3.0)


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
