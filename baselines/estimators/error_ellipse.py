"""Error ellipse: a covariance of positions as two axes and a direction, as it is sent.

Gutierrez et al. 2009 (TR), Section 5.2.
"""

import math

from baselines.estimators.path_covariance import spectral_norm
from swarm_forage_env.compiler import kernel
from swarm_forage_env.equations.elementary import atan2, cos_sin

Matrix = tuple[float, float, float]
"""The symmetric 2 x 2 covariance of a position: xx, xy, yy [m^2]."""


@kernel
def to_ellipse(xx: float, xy: float, yy: float) -> tuple[float, float, float]:
    """Standard deviations along the long and the short axis [m], direction of the long [rad].

    The matrix is a covariance of positions [m^2].
    """
    long = spectral_norm(xx, xy, yy)
    short = max(xx + yy - long, 0.0)
    return math.sqrt(long), math.sqrt(short), 0.5 * atan2(2.0 * xy, xx - yy)


@kernel
def to_matrix(long: float, short: float, direction: float) -> Matrix:
    """The covariance (xx, xy, yy) [m^2] of the ellipse of these axes [m] and direction [rad]."""
    c, s = cos_sin(direction)
    u, v = long * long, short * short
    return u * c * c + v * s * s, (u - v) * c * s, u * s * s + v * c * c


@kernel
def heard_direction(gamma_i: float, gamma_j: float, psi_j: float) -> float:
    """A direction psi_j of the sender's body frame in the receiver's body frame [rad].

        psi_i = gamma_i + (psi_j - gamma_j) - pi

    gamma_i, gamma_j are the bearings of the beam at the receiver and at the sender [rad].

    Source: TR, Section 5.2 (before Eq. 40).
    """
    return gamma_i + (psi_j - gamma_j) - math.pi
