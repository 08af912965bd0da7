"""How the covariance of a pose grows with the path."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

from baselines.estimators.uncertainty import (
    add_noise,
    carry,
    error_constant,
    spectral_norm,
    spread,
)
from swarm_forage_env.kernels.diff_drive import advance, wheels_to_arc

AXLE = 0.053
PLACE = ([0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2])


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
    carry(found, drho, zeta)
    add_noise(found, drho, zeta, q[0, 0], q[1, 1], AXLE)
    assert_allclose(matrix(found), A @ before @ A.T + W @ q @ W.T, rtol=1e-12, atol=1e-15)


def test_the_covariance_is_that_of_many_noisy_walks():
    ticks, walks, error = 60, 4000, 1e-4
    rng = np.random.default_rng(2)
    right, left = np.full(ticks, 0.004), np.full(ticks, 0.0039)
    k = error**2 / 3.0 / 0.00395
    odometry = np.array([wheels_to_arc(*u, AXLE) for u in zip(left, right, strict=True)])
    true, found = np.zeros(3), np.zeros((1, 2, 6))
    p, nowhere = np.zeros((1, 2)), np.full(1, -1, np.int8)
    for step in odometry:
        true = np.array(advance(*true, *step))
        reading = step[None].astype(np.float32)
        spread(reading, AXLE, k, true[None].copy(), nowhere, found, p)
    ends = np.zeros((walks, 3))
    for walk in range(walks):
        noise = rng.uniform(-error, error, size=(ticks, 2))
        pose = (0.0, 0.0, 0.0)
        for step in range(ticks):
            arc = wheels_to_arc(left[step] + noise[step, 0], right[step] + noise[step, 1], AXLE)
            pose = advance(*pose, *arc)
        ends[walk] = pose
    scale = np.sqrt(np.diag(matrix(found[0, 0])))
    sampled = np.cov(ends.T) / np.outer(scale, scale)
    assert_allclose(matrix(found[0, 0]) / np.outer(scale, scale), sampled, atol=0.1)
    assert p[0, 0] == pytest.approx(math.sqrt(np.linalg.eigvalsh(np.cov(ends.T)[:2, :2])[1]), 0.05)


def test_the_error_constant_matches_the_encoders_at_the_cruise_speed():
    step = 0.04 * 0.1
    k = error_constant(wheel_noise=0.07, cruise_speed=0.04, tick=0.1)
    assert k * step == pytest.approx((0.07 * step) ** 2 / 3.0)


def test_the_norm_is_the_largest_eigenvalue():
    for root in np.random.default_rng(3).normal(size=(20, 2, 2)):
        P = root @ root.T  # noqa: N806 as in the paper
        assert spectral_norm(P[0, 0], P[0, 1], P[1, 1]) == pytest.approx(np.linalg.norm(P, 2))


def test_nothing_is_uncertain_on_the_area():
    found, p = np.ones((1, 2, 6)), np.ones((1, 2))
    reading = np.full((1, 2), 0.01, np.float32)
    spread(reading, AXLE, 1e-5, np.zeros((1, 3)), np.zeros(1, np.int8), found, p)
    assert (found[0, 0] == 0.0).all()
    assert p[0, 0] == 0.0
    assert p[0, 1] > 1.0
