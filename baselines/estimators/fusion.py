"""Covariance intersection of estimates from outside, checked before anything is fused."""

import numpy as np
from numpy.typing import ArrayLike

from baselines.estimators.covariance_intersection import fast_ci_weights, fuse
from baselines.estimators.matrices import determinant3
from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.errors import ConfigError

ASYMMETRY = 1e-9
"""Largest difference of two mirrored entries, as a share of the largest entry."""

SINGULAR = 1e-12
"""Smallest eigenvalue, as a share of the largest, of a covariance that has an inverse."""


def intersect_estimates(
    poses: ArrayLike, covariances: ArrayLike
) -> tuple[Float64[Array, "3"], Float64[Array, "3 3"]]:
    """Fuse L estimates of one pose, shape (L, 3), with covariances (L, 3, 3): pose and covariance.

    x, y [m] and heading [rad]; headings must lie on the same turn. ConfigError names the first
    entry that cannot be used: of another shape, not finite, not symmetric, or not invertible.

    Source: BOIDS, Eq. 4 and 5.

    >>> pose, P = intersect_estimates([[0, 0, 0], [1, 0, 0]], [np.eye(3), np.eye(3)])
    >>> pose.tolist()
    [0.5, 0.0, 0.0]
    """
    x = _numbers("poses", poses, (3,))
    P = _numbers("covariances", covariances, (3, 3))
    if len(x) != len(P) or not len(x):
        raise ConfigError(f"poses and covariances: {len(x)} and {len(P)}; must be as many, and one")
    for k, each in enumerate(P):
        check_covariance(f"covariances[{k}]", each)
    inverses, weights = np.linalg.inv(P), np.zeros(len(P))
    fast_ci_weights(inverses, len(P), np.zeros((2, 3, 3)), weights)
    pose, covariance = np.zeros(3), np.zeros((3, 3))
    fuse(len(P), inverses, x, weights, np.zeros((3, 3)), pose, covariance)
    return pose, covariance


def check_covariance(name: str, P: Float64[Array, "3 3"]) -> None:
    """ConfigError, with the entry, unless a 3 x 3 matrix is symmetric, positive and invertible."""
    size = float(np.abs(P).max())
    for a in range(3):
        for b in range(a):
            if abs(P[a, b] - P[b, a]) > ASYMMETRY * size:
                raise ConfigError(
                    f"{name}[{a}, {b}]={P[a, b]:g}: must equal [{b}, {a}]={P[b, a]:g}, for a"
                    " covariance is symmetric; take (P + P') / 2"
                )
    for a in range(3):
        if P[a, a] <= 0.0:
            raise ConfigError(f"{name}[{a}, {a}]={P[a, a]:g}: a variance must be above 0")
    low, *_, high = np.linalg.eigvalsh(P)
    if low <= SINGULAR * high:
        raise ConfigError(
            f"{name}: has no inverse (determinant {determinant3(P):.3g}, eigenvalues from {low:.3g}"
            f" to {high:.3g}); every direction needs a variance above 0"
        )


def _numbers(name: str, given: ArrayLike, shape: tuple[int, ...]) -> Float64[Array, "L ..."]:
    try:
        found = np.array(given, np.float64)
    except (TypeError, ValueError):
        raise ConfigError(f"{name}: must be numbers, of shape (L, {shape[0]}, ...)") from None
    if found.shape[1:] != shape:
        wanted = ", ".join(map(str, shape))
        raise ConfigError(f"{name}: of shape {found.shape}; must be (L, {wanted})")
    for entry in np.argwhere(~np.isfinite(found)):
        where = ", ".join(map(str, entry))
        raise ConfigError(f"{name}[{where}]={found[tuple(entry)]}: must be a finite number")
    return found
