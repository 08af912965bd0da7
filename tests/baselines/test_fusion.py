"""Estimates from outside: fused if they can be, refused with the entry if not."""

import numpy as np
import pytest

from baselines.estimators.fusion import check_covariance, intersect_estimates
from swarm_forage_env.errors import ConfigError

P = np.array([[0.4, 0.1, 0.0], [0.1, 0.3, 0.05], [0.0, 0.05, 0.2]])
POSES = [[0.0, 0.0, 0.0], [1.0, 2.0, 0.1]]


def changed(entry, value):
    found = P.copy()
    found[entry] = value
    return found


def test_two_estimates_meet_by_their_weights():
    other = 3.0 * P
    pose, fused = intersect_estimates(POSES, [P, other])
    S = np.linalg.inv(P) + np.linalg.inv(other)  # noqa: N806 as in the paper
    det = np.linalg.det
    w = (det(S) - det(np.linalg.inv(other)) + det(np.linalg.inv(P))) / (2.0 * det(S))
    information = w * np.linalg.inv(P) + (1.0 - w) * np.linalg.inv(other)
    np.testing.assert_allclose(fused, np.linalg.inv(information), rtol=1e-7, atol=1e-15)
    mean = fused @ ((1.0 - w) * np.linalg.inv(other) @ POSES[1])
    np.testing.assert_allclose(pose, mean)


def test_a_single_estimate_stays_as_it_is():
    pose, fused = intersect_estimates(POSES[1:], [P])
    np.testing.assert_allclose(pose, POSES[1])
    np.testing.assert_allclose(fused, P)


@pytest.mark.parametrize(
    ("covariance", "complaint"),
    [
        (changed((1, 0), 0.3), r"covariances\[1\]\[1, 0\]=0.3: must equal \[0, 1\]=0.1"),
        (changed((2, 2), 0.0), r"covariances\[1\]\[2, 2\]=0: a variance must be above 0"),
        (np.ones((3, 3)), r"covariances\[1\]: has no inverse"),
        (np.diag([1.0, 1.0, 1e-14]), r"covariances\[1\]: has no inverse"),
        (changed((0, 2), np.nan), r"covariances\[1, 0, 2\]=nan: must be a finite number"),
        (changed((0, 2), np.inf), r"covariances\[1, 0, 2\]=inf: must be a finite number"),
    ],
)
def test_a_covariance_that_is_none_is_refused_with_its_entry(covariance, complaint):
    with pytest.raises(ConfigError, match=complaint):
        intersect_estimates(POSES, [P, covariance])


@pytest.mark.parametrize(
    ("poses", "covariances", "complaint"),
    [
        ([[0.0, 0.0]], [P], r"poses: of shape \(1, 2\); must be \(L, 3\)"),
        (POSES, [P], "2 and 1; must be as many"),
        (POSES, [np.eye(2)] * 2, r"covariances: of shape \(2, 2, 2\); must be \(L, 3, 3\)"),
        ("abc", [P], "poses: must be numbers"),
    ],
)
def test_other_shapes_are_refused(poses, covariances, complaint):
    with pytest.raises(ConfigError, match=complaint):
        intersect_estimates(poses, covariances)


def test_what_is_refused_is_left_as_it_was():
    given = changed((1, 0), 0.3)
    before = given.copy()
    with pytest.raises(ConfigError):
        check_covariance("P", given)
    np.testing.assert_array_equal(given, before)
