"""Path covariance: how the uncertainty of an estimate grows with the path since its area.

Moments are the six numbers of a symmetric 3 x 3 covariance of a pose: (xx, xy, yy) [m^2],
(xt, yt) [m rad] and tt [rad^2], t being the heading; in the robot's own frame.
"""

import math

import numpy as np

from baselines.estimators.area_memory import update_belief as update_social_belief
from baselines.estimators.belief import Belief, SocialMind
from swarm_forage_env.arrays import Array, Float32, Float64
from swarm_forage_env.compiler import kernel
from swarm_forage_env.epuck.records import Readings
from swarm_forage_env.equations.elementary import atan2, cos_sin, hypot
from swarm_forage_env.record import Numbers, field

XX, XY, YY, XT, YT, TT = range(6)
N_MOMENTS = 6

Moments = Float64[Array, "6"]

Matrix = tuple[float, float, float]
"""The symmetric 2 x 2 covariance of a position: xx, xy, yy [m^2]."""


class CovarianceBelief(Belief):
    """What a robot believes, and how uncertain its pose has become since each area.

    Its p is the standard deviation of the position along the worst direction [m].
    """

    moments: Float64[Array, "areas 6"] = field(np.float64, 2, N_MOMENTS, unit="m^2, m rad, rad^2")
    """Covariance of the pose since each area."""


class CovarianceMind(SocialMind):
    """All that a covariance filter keeps of a robot."""

    belief: CovarianceBelief = field(CovarianceBelief)


def error_constant(wheel_noise: float, cruise_speed: float, tick: float) -> float:
    """The error constant k [m] of Q = diag(k |dU_r|, k |dU_l|) that matches the encoders.

        k = (a v dt)^2 / (3 v dt) = a^2 v dt / 3

    An encoder errs uniformly by +- a v dt, of variance (a v dt)^2 / 3, whatever its wheel's
    path; k matches it at the path v dt of the cruise speed v.

    Source: TR, Eq. 10, for Q; ANTS, Section 4.1, for the noise.

    >>> round(error_constant(0.3, 0.1, 1.0), 6)
    0.003
    """
    return wheel_noise**2 * cruise_speed * tick / 3.0


@kernel
def propagate(P: Moments, drho: float, zeta: float) -> None:
    """The moments P after a step of drho [m] in direction zeta [rad], encoders exact; in place.

        P = A P A'
        A = [1 0 -drho sin(zeta); 0 1 drho cos(zeta); 0 0 1]

    Source: TR, Eq. 9 and 11.
    """
    c, s = cos_sin(zeta)
    u, v = -drho * s, drho * c
    P[XX] += 2.0 * u * P[XT] + u * u * P[TT]
    P[XY] += u * P[YT] + v * P[XT] + u * v * P[TT]
    P[YY] += 2.0 * v * P[YT] + v * v * P[TT]
    P[XT] += u * P[TT]
    P[YT] += v * P[TT]


@kernel
def add_noise(P: Moments, drho: float, zeta: float, q_r: float, q_l: float, axle: float) -> None:
    """Add to the moments P what encoders of variance q_r and q_l [m^2] bring, in place.

        P = P + W Q W',  Q = diag(q_r, q_l)
        W = [ c / 2 - e s    c / 2 + e s
              s / 2 + e c    s / 2 - e c
              1 / b          -1 / b      ]

    c, s = cos(zeta), sin(zeta) of the step's direction [rad]; e = drho / (2 b); b = axle [m].

    Source: TR, Eq. 9 and 11.
    """
    c, s = cos_sin(zeta)
    c, s = 0.5 * c, 0.5 * s
    e = drho / axle
    for side in range(2):
        sign, q = (1.0, q_r) if side == 0 else (-1.0, q_l)
        x, y, t = c - sign * e * s, s + sign * e * c, sign / axle
        P[XX] += q * x * x
        P[XY] += q * x * y
        P[YY] += q * y * y
        P[XT] += q * x * t
        P[YT] += q * y * t
        P[TT] += q * t * t


@kernel
def spectral_norm(xx: float, xy: float, yy: float) -> float:
    """The largest eigenvalue of a symmetric, positive 2 x 2 matrix.

    Source: TR, Eq. 27.

    >>> spectral_norm(2.0, 0.0, 3.0)
    3.0
    """
    return 0.5 * (xx + yy) + hypot(0.5 * (xx - yy), xy)


@kernel
def worst_deviation(P: Moments) -> float:
    """The standard deviation of the position along the worst direction [m]: p^2 = |P|."""
    return math.sqrt(max(spectral_norm(P[XX], P[XY], P[YY]), 0.0))


@kernel
def grow_covariances(
    belief: CovarianceBelief, odometry: Float32[Array, "2"], numbers: Numbers
) -> None:
    """Grow the covariances by the step that led to the believed pose; on an area they are zero.

        q_r, q_l = k |drho +- b dtheta / 2|

    Source: TR, Eq. 10 and 32.
    """
    drho, dtheta = float(odometry[0]), float(odometry[1])
    k, axle = numbers.error_constant, numbers.axle
    q_r, q_l = k * abs(drho + 0.5 * axle * dtheta), k * abs(drho - 0.5 * axle * dtheta)
    zeta = belief.pose[2] - 0.5 * dtheta
    for area in range(2):
        P = belief.moments[area]
        if belief.on_area == area:
            for moment in range(N_MOMENTS):
                P[moment] = 0.0
        else:
            propagate(P, drho, zeta)
            add_noise(P, drho, zeta, q_r, q_l, axle)
        belief.p[area] = worst_deviation(P)


@kernel
def update_belief(
    mind: CovarianceMind, shared: Array, readings: Readings, numbers: Numbers
) -> None:
    """Social odometry's tick, with growing covariances."""
    update_social_belief(mind, shared, readings, numbers)
    grow_covariances(mind.belief, readings.odometry, numbers)


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
