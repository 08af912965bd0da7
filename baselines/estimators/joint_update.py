"""The joint update of two poses by how one robot sees the other: Jacobian, gain, covariance.

Smith et al. 2021 (BOIDS), Section 2.3; Luft et al. 2016 and 2018.

A pair's joint covariance is [P_i C; C' P_j]; the first three rows are those of robot i.
"""

import math

import numpy as np

from baselines.estimators.pose_prediction import PoseMind
from baselines.estimators.small_matrices import (
    Matrix3,
    cholesky3,
    inverse3,
    product3,
    product3_transposed,
    solve_lower3,
    spectral_norm3,
    transpose3,
)
from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.compiler import kernel
from swarm_forage_env.record import Record, field

COHERENCE = 0.999  # largest share of the possible correlation of two robots' errors (chosen)
Factors = Float64[Array, "robots 3 3"]  # what a robot keeps of its cross-covariance with each robot

Joint = Float64[Array, "6 6"]
Jacobian = Float64[Array, "2 6"]
Gain = Float64[Array, "6 2"]


class JointUpdate(Record):
    """Working space of one relative update."""

    cross: Matrix3 = field(np.float64, 3, 3)
    """C, the cross-covariance of the pair."""
    joint: Joint = field(np.float64, 6, 6)
    """The covariance of the pair before the update."""
    half: Joint = field(np.float64, 6, 6)
    """((I - K G) P)'."""
    after: Joint = field(np.float64, 6, 6)
    """The covariance of the pair after the update."""
    G: Jacobian = field(np.float64, 2, 6)
    """Derivative of range and bearing by both poses."""
    K: Gain = field(np.float64, 6, 2)
    """The gain."""
    before: Float64[Array, "pair 3 3"] = field(np.float64, 2, 3, 3)
    """Each robot's own covariance before the update."""
    L: Matrix3 = field(np.float64, 3, 3)
    """A lower triangle, L L' = P."""
    products: Float64[Array, "4 3 3"] = field(np.float64, 4, 3, 3)
    """Intermediate products."""


class FilterMind(PoseMind):
    """All that the decentralised Kalman filter keeps of a robot, but its factors."""

    update: JointUpdate = field(JointUpdate)


@kernel
def sight_jacobian(dx: float, dy: float, by_heading: float, out_G: Jacobian) -> None:
    """Derivative by both poses of the range and bearing at which i sees j.

        G_i = [-dx/r -dy/r 0; dy/r^2 -dx/r^2 -1],  G_j = [dx/r dy/r 0; -dy/r^2 dx/r^2 0]

    (dx, dy) = x_j - x_i [m]; `by_heading`: -1 for a bearing of the body frame, 0 for a global one.

    Source: BOIDS, Eq. 14, whose first block has no heading.
    """
    r2 = dx * dx + dy * dy
    r = math.sqrt(r2)
    out_G[0, 2] = out_G[0, 5] = out_G[1, 5] = 0.0
    out_G[0, 0], out_G[0, 1], out_G[0, 3], out_G[0, 4] = -dx / r, -dy / r, dx / r, dy / r
    out_G[1, 0], out_G[1, 1], out_G[1, 3], out_G[1, 4] = dy / r2, -dx / r2, -dy / r2, dx / r2
    out_G[1, 2] = by_heading


@kernel
def joint_gain(update: JointUpdate, g: float, var_range: float, var_bearing: float) -> None:
    """The gain of a relative measurement on both poses, scaled by g.

        K = g P G' (G P G' + R)^-1,  R = diag(var_range, var_bearing)

    Source: BOIDS, Eq. 16.
    """
    G, K = update.G, update.K
    for a in range(6):
        for k in range(2):
            K[a, k] = 0.0
            for b in range(6):
                K[a, k] += update.joint[a, b] * G[k, b]
    s00, s01, s11 = var_range, 0.0, var_bearing
    for b in range(6):
        s00 += G[0, b] * K[b, 0]
        s01 += G[0, b] * K[b, 1]
        s11 += G[1, b] * K[b, 1]
    scale = 1.0 / (s00 * s11 - s01 * s01)
    for a in range(6):
        k0, k1 = K[a, 0], K[a, 1]
        K[a, 0] = scale * (k0 * s11 - k1 * s01) * g
        K[a, 1] = scale * (k1 * s00 - k0 * s01) * g


@kernel
def left_over(A: Joint, G: Jacobian, K: Gain, out: Joint) -> None:
    """((I - K G) A)', transposed so that two calls give (I - K G) A (I - K G)'."""
    for b in range(6):
        seen_range, seen_bearing = 0.0, 0.0
        for c in range(6):
            seen_range += G[0, c] * A[c, b]
            seen_bearing += G[1, c] * A[c, b]
        for a in range(6):
            out[b, a] = A[a, b] - K[a, 0] * seen_range - K[a, 1] * seen_bearing


@kernel
def correct_joint(update: JointUpdate, var_range: float, var_bearing: float) -> None:
    """The covariance of both after the measurement, for any gain: positive semi-definite.

        P = (I - K G) P (I - K G)' + K R K'

    Source: BucyJoseph1968, for BOIDS, Eq. 17.
    """
    G, K, after = update.G, update.K, update.after
    left_over(update.joint, G, K, update.half)
    left_over(update.half, G, K, after)
    for a in range(6):
        for b in range(a + 1):
            noise = var_range * K[a, 0] * K[b, 0] + var_bearing * K[a, 1] * K[b, 1]
            after[a, b] = after[b, a] = 0.5 * (after[a, b] + after[b, a]) + noise


@kernel
def bound_correlation(P_i: Matrix3, P_j: Matrix3, update: JointUpdate) -> None:
    """Shrink the cross-covariance C, in place, to what the two covariances allow.

        |L_i^-1 C L_j^-T| <= COHERENCE,  L L' = P

    Luft's factors only approximate C once others have corrected either robot, and may exceed what
    two robots can share: then the joint matrix is no covariance.

    Source: HornJohnson2012, Theorem 7.7.7.
    """
    L, C = update.L, update.cross
    half, turned = update.products[0], update.products[1]
    M, square = update.products[2], update.products[3]
    cholesky3(P_i, L)
    solve_lower3(L, C, half)
    transpose3(half, turned)
    cholesky3(P_j, L)
    solve_lower3(L, turned, M)
    product3_transposed(M, M, square)
    most = math.sqrt(spectral_norm3(square))
    if most > COHERENCE:
        for a in range(3):
            for b in range(3):
                C[a, b] *= COHERENCE / most


@kernel
def join(P_i: Matrix3, P_j: Matrix3, update: JointUpdate) -> None:
    """Write the joint covariance [P_i C; C' P_j], and keep each robot's own in `before`."""
    C, joint, before = update.cross, update.joint, update.before
    for a in range(3):
        for b in range(3):
            joint[a, b] = before[0, a, b] = P_i[a, b]
            joint[a, b + 3] = C[a, b]
            joint[a + 3, b] = C[b, a]
            joint[a + 3, b + 3] = before[1, a, b] = P_j[a, b]


@kernel
def multiply_factors(M: Matrix3, factors: Factors) -> None:
    """M s_ih for every robot h, in place; written out, as most of a correction's time goes here."""
    for h in range(factors.shape[0]):
        for k in range(3):
            a, b, c = factors[h, 0, k], factors[h, 1, k], factors[h, 2, k]
            factors[h, 0, k] = M[0, 0] * a + M[0, 1] * b + M[0, 2] * c
            factors[h, 1, k] = M[1, 0] * a + M[1, 1] * b + M[1, 2] * c
            factors[h, 2, k] = M[2, 0] * a + M[2, 1] * b + M[2, 2] * c


@kernel
def update_factors(before: Matrix3, after: Matrix3, update: JointUpdate, factors: Factors) -> None:
    """The factors of a robot whose covariance was corrected from Q to P, in place.

        s_ih = P Q^-1 s_ih

    Source: BOIDS, Eq. 19 and 20; Luft2018, Eq. 16.
    """
    undo, ratio = update.products[0], update.products[1]
    inverse3(before, undo)
    product3(after, undo, ratio)
    multiply_factors(ratio, factors)
