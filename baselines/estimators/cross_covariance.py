"""Cross-covariances of the decentralised EKF of e-pucks: errors that robots share.

For every other robot and area, a robot keeps the cross-covariance of both robots' estimates since
their last exchange, in its own frame: `shared[robot, area]`, 2 x 2 [m^2].
"""

import math

import numpy as np

from baselines.estimators.covariance import (
    EllipseBelief,
    EllipseMind,
    Gain,
    copy_ellipse,
    heard_covariance,
    move_location,
)
from baselines.estimators.message_exchange import is_merged
from baselines.estimators.sikf import (
    XT,
    XX,
    XY,
    YT,
    YY,
    Matrix,
    Moments,
    spectral_norm,
    worst_deviation,
)
from baselines.estimators.sikf import update_belief as update_covariances
from swarm_forage_env.arrays import Array, Float64, Int8
from swarm_forage_env.compiler import kernel
from swarm_forage_env.epuck.records import Readings
from swarm_forage_env.record import Numbers, field

COHERENCE = 0.999  # largest correlation allowed between two robots' errors (chosen)

Shared = Float64[Array, "robots areas 2 2"]


class CrossBelief(EllipseBelief):
    """Belief that marks the areas with an error shared with other robots."""

    is_shared: Int8[Array, " areas"] = field(np.int8, 2)
    """Whether a cross-covariance of the area may differ from zero."""


class CrossMind(EllipseMind):
    """State of a robot under the decentralised EKF."""

    belief: CrossBelief = field(CrossBelief)


@kernel
def forget_area(shared: Shared, area: int) -> None:
    """Set the cross-covariances of an area to zero."""
    for other in range(shared.shape[0]):
        for a in range(2):
            for b in range(2):
                shared[other, area, a, b] = 0.0


@kernel
def forget_cross_covariances(belief: CrossBelief, shared: Shared) -> None:
    """Set to zero the cross-covariances of areas that are under the robot or unknown."""
    for area in range(2):
        if belief.is_shared[area] and (belief.on_area == area or not belief.known[area]):
            forget_area(shared, area)
            belief.is_shared[area] = False


@kernel
def update_belief(mind: CrossMind, shared: Shared, readings: Readings, numbers: Numbers) -> None:
    """Update the belief as in `sikf`; the error of an area just found is shared with no robot."""
    update_covariances(mind, shared, readings, numbers)
    forget_cross_covariances(mind.belief, shared)


@kernel
def bounded(P: Moments, R: Matrix, C: Float64[Array, "2 2"]) -> float:
    """Return the factor that shrinks a cross-covariance C to the bound set by P and R.

    |C|^2 <= COHERENCE^2 (least eigenvalue of P) (least eigenvalue of R) keeps [P C; C' R] a
    covariance, for any directions.

    Source: HornJohnson2012, Theorem 7.7.7, with norms for matrices.
    """
    least_p = max(P[XX] + P[YY] - spectral_norm(P[XX], P[XY], P[YY]), 0.0)
    least_r = max(R[0] + R[2] - spectral_norm(R[0], R[1], R[2]), 0.0)
    square = 0.0
    for a in range(2):
        for b in range(2):
            square += C[a, b] ** 2
    most = COHERENCE**2 * least_p * least_r
    return math.sqrt(most / square) if square > most else 1.0


@kernel
def quadratic(u0: float, u1: float, v0: float, v1: float, S: Matrix) -> float:
    """Return the form u S v' of two rows u, v and a symmetric matrix S."""
    return u0 * (S[0] * v0 + S[1] * v1) + u1 * (S[1] * v0 + S[2] * v1)


@kernel
def correct_moments(P: Moments, K: Gain, A: Gain, S: Matrix) -> None:
    """Correct the moments P with the gain K, in place.

        P = P - K A' - A K' + K S K'

    A = P - C and S = P + R - C - C' before the correction; the variance of the heading stays.

    Source: BOIDS, Eq. 17.
    """
    k00, k01, k10, k11 = K
    a00, a01, a10, a11 = A
    P[XX] += -2.0 * (k00 * a00 + k01 * a01) + quadratic(k00, k01, k00, k01, S)
    P[YY] += -2.0 * (k10 * a10 + k11 * a11) + quadratic(k10, k11, k10, k11, S)
    P[XY] -= k00 * a10 + k01 * a11 + k10 * a00 + k11 * a01
    P[XY] += quadratic(k00, k01, k10, k11, S)
    xt, yt = P[XT], P[YT]
    P[XT] = (1.0 - k00) * xt - k01 * yt
    P[YT] = -k10 * xt + (1.0 - k11) * yt


@kernel
def correct_cross_covariances(shared: Shared, partner: int, area: int, K: Gain, R: Matrix) -> None:
    """Update the cross-covariances of an area after a correction by a partner, in place.

        C = C + K (R - C) of the partner,  C_h = (I - K) C_h of every other robot h

    Source: BOIDS, Eq. 18 to 20, of which a robot keeps its own half.
    """
    k00, k01, k10, k11 = K
    C = shared[partner, area]
    c00, c01, c10, c11 = C[0, 0], C[0, 1], C[1, 0], C[1, 1]
    b00, b01, b10, b11 = R[0] - c00, R[1] - c01, R[1] - c10, R[2] - c11
    for h in range(shared.shape[0]):
        for k in range(2):
            u, v = shared[h, area, 0, k], shared[h, area, 1, k]
            shared[h, area, 0, k] = (1.0 - k00) * u - k01 * v
            shared[h, area, 1, k] = -k10 * u + (1.0 - k11) * v
    C[0, 0], C[0, 1] = c00 + k00 * b00 + k01 * b10, c01 + k00 * b01 + k01 * b11
    C[1, 0], C[1, 1] = c10 + k10 * b00 + k11 * b10, c11 + k10 * b01 + k11 * b11


@kernel
def correct_shared(belief: CrossBelief, area: int, R: Matrix, share: float, shared: Shared) -> None:
    """Correct the estimate of an area by the partner's, given their cross-covariance C, in place.

        K = (P - C) (P + R - C - C')^-1

    `share` scales the gain. Without the inverse, as for equal errors, nothing is corrected.

    Source: BOIDS, Eq. 15 and 16.
    """
    P, C = belief.moments[area], shared[belief.last_partner, area]
    factor = bounded(P, R, C)
    for a in range(2):
        for b in range(2):
            C[a, b] *= factor
    a00, a01 = P[XX] - C[0, 0], P[XY] - C[0, 1]
    a10, a11 = P[XY] - C[1, 0], P[YY] - C[1, 1]
    s00 = P[XX] + R[0] - 2.0 * C[0, 0]
    s01 = P[XY] + R[1] - C[0, 1] - C[1, 0]
    s11 = P[YY] + R[2] - 2.0 * C[1, 1]
    det = s00 * s11 - s01 * s01
    if det > 1e-12 * (s00 + s11) ** 2:
        K = (
            share * (a00 * s11 - a01 * s01) / det, share * (a01 * s00 - a00 * s01) / det,
            share * (a10 * s11 - a11 * s01) / det, share * (a11 * s00 - a10 * s01) / det,
        )  # fmt: skip
        move_location(belief, area, K)
        correct_moments(P, K, (a00, a01, a10, a11), (s00, s01, s11))
        correct_cross_covariances(shared, belief.last_partner, area, K, R)
        belief.is_shared[area] = True


@kernel
def merge(mind: CrossMind, shared: Shared, heard_p_share: float, numbers: Numbers) -> None:
    """Copy heard estimates of unknown areas with their errors; correct those of known areas.

    The weight g scales the gain by 2 g, at most by 1: g = 1/2 gives the whole gain, as in
    `covariance`.

    Source: TR, Eq. 14; BOIDS, Eq. 12 to 20.
    """
    belief = mind.belief
    for area in range(2):
        if is_merged(belief, area, numbers):
            R = heard_covariance(belief, area)
            if belief.known[area]:
                share = min(2.0 * float(mind.exchange.weight[area]), 1.0)
                correct_shared(belief, area, R, share, shared)
            else:
                copy_ellipse(belief, area, R)
                forget_area(shared, area)
                C = shared[belief.last_partner, area]
                C[0, 0], C[0, 1], C[1, 0], C[1, 1] = R[0], R[1], R[1], R[2]
                belief.is_shared[area] = True
            belief.p[area] = worst_deviation(belief.moments[area])
