"""Kernels of the decentralised EKF among e-pucks: errors that robots share."""

import math

from baselines.estimators.beliefs import NOWHERE
from baselines.estimators.uncertainty import TT, XT, XX, XY, YT, YY, spectral_norm
from swarm_forage_env.arrays import Array, Bool, Float32, Float64, Int8, Int32
from swarm_forage_env.kernels.compiler import kernel

COHERENCE = 0.999
"""Most that two robots' errors may be believed to go together, of what is possible (chosen)."""


@kernel
def forget_correlations(
    on_area: Int8[Array, " rows"],
    known: Bool[Array, "rows areas"],
    correlations: Float64[Array, "rows robots areas 2 2"],
) -> None:
    """Forget what is shared of an area that is under the robot, or not known any more."""
    for i in range(on_area.shape[0]):
        for area in range(2):
            if on_area[i] == area or not known[i, area]:
                for j in range(correlations.shape[1]):
                    correlations[i, j, area, :, :] = 0.0


@kernel
def bounded(  # noqa: PLR0913 two matrices, entry by entry
    xx: float, xy: float, yy: float, rxx: float, rxy: float, ryy: float,
    C: Float64[Array, "2 2"],
) -> float:  # fmt: skip
    """The factor that shrinks a cross-covariance C to what the covariances P and R allow.

    |C|^2 <= COHERENCE^2 (least eigenvalue of P) (least eigenvalue of R) keeps [P C; C' R] a
    covariance, whatever their directions.

    Source: HornJohnson2012, Theorem 7.7.7, with norms for matrices.
    """
    least_p = max(xx + yy - spectral_norm(xx, xy, yy), 0.0)
    least_r = max(rxx + ryy - spectral_norm(rxx, rxy, ryy), 0.0)
    square = 0.0
    for a in range(2):
        for b in range(2):
            square += C[a, b] ** 2
    most = COHERENCE**2 * least_p * least_r
    return math.sqrt(most / square) if square > most else 1.0


@kernel
def correct_shared(  # noqa: PLR0913 inputs first, then what is updated
    i: int,
    area: int,
    partner: int,
    dx: float,
    dy: float,
    share: float,
    R: Float64[Array, "3"],
    place: Float64[Array, "2"],
    P: Float64[Array, "6"],
    correlations: Float64[Array, "rows robots areas 2 2"],
) -> None:
    """Correct robot i's place of an area by a partner's, which is off by (dx, dy), in place.

        K = (P - C) (P + R - C - C')^-1
        x = x + K (X - x),  P = P - K (P - C)',  C = C + K (R - C)
        C_h = (I - K) C_h for every other robot h

    `share` scales the gain; where the two errors are the same there is nothing to gain.

    Source: BOIDS, Eq. 16 to 20, of which robot i keeps its own half.
    """
    C = correlations[i, partner, area]
    C *= bounded(P[XX], P[XY], P[YY], R[0], R[1], R[2], C)
    a00, a01 = P[XX] - C[0, 0], P[XY] - C[0, 1]
    a10, a11 = P[XY] - C[1, 0], P[YY] - C[1, 1]
    s00 = P[XX] + R[0] - 2.0 * C[0, 0]
    s01 = P[XY] + R[1] - C[0, 1] - C[1, 0]
    s11 = P[YY] + R[2] - 2.0 * C[1, 1]
    det = s00 * s11 - s01 * s01
    if det <= 1e-12 * (s00 + s11) ** 2:
        return
    k00, k01 = share * (a00 * s11 - a01 * s01) / det, share * (a01 * s00 - a00 * s01) / det
    k10, k11 = share * (a10 * s11 - a11 * s01) / det, share * (a11 * s00 - a10 * s01) / det
    place[0] += k00 * dx + k01 * dy
    place[1] += k10 * dx + k11 * dy
    P[XX] += -2.0 * (k00 * a00 + k01 * a01) + _quadratic(k00, k01, k00, k01, s00, s01, s11)
    P[YY] += -2.0 * (k10 * a10 + k11 * a11) + _quadratic(k10, k11, k10, k11, s00, s01, s11)
    P[XY] -= k00 * a10 + k01 * a11 + k10 * a00 + k11 * a01
    P[XY] += _quadratic(k00, k01, k10, k11, s00, s01, s11)
    xt, yt = P[XT], P[YT]
    P[XT] = (1.0 - k00) * xt - k01 * yt
    P[YT] = -k10 * xt + (1.0 - k11) * yt
    b00, b01, b10, b11 = R[0] - C[0, 0], R[1] - C[0, 1], R[1] - C[1, 0], R[2] - C[1, 1]
    c00, c01, c10, c11 = C[0, 0], C[0, 1], C[1, 0], C[1, 1]
    for h in range(correlations.shape[1]):
        for k in range(2):
            u, v = correlations[i, h, area, 0, k], correlations[i, h, area, 1, k]
            correlations[i, h, area, 0, k] = (1.0 - k00) * u - k01 * v
            correlations[i, h, area, 1, k] = -k10 * u + (1.0 - k11) * v
    C[0, 0], C[0, 1] = c00 + k00 * b00 + k01 * b10, c01 + k00 * b01 + k01 * b11
    C[1, 0], C[1, 1] = c10 + k10 * b00 + k11 * b10, c11 + k10 * b01 + k11 * b11


@kernel
def _quadratic(  # noqa: PLR0913 two rows and a matrix, entry by entry
    u0: float, u1: float, v0: float, v1: float, s00: float, s01: float, s11: float
) -> float:
    """u S v' of two rows and a symmetric matrix."""
    return u0 * (s00 * v0 + s01 * v1) + u1 * (s01 * v0 + s11 * v1)


@kernel
def merge_correlated(  # noqa: PLR0913 inputs first, then what is updated
    ended: Bool[Array, " rows"],
    g: Float32[Array, "rows areas"],
    double: bool,
    partner: Int32[Array, " rows"],
    goal: Int8[Array, " rows"],
    heard_sum: Float64[Array, "rows areas 2"],
    heard_weight: Float64[Array, "rows areas"],
    heard_cov: Float64[Array, "rows areas 3"],
    location: Float64[Array, "rows areas 2"],
    p: Float64[Array, "rows areas"],
    known: Bool[Array, "rows areas"],
    moments: Float64[Array, "rows areas 6"],
    correlations: Float64[Array, "rows robots areas 2 2"],
) -> None:
    """Copy what was unknown; correct what both know, about the goal (single) or both (double).

    A copied place shares all of its error with the partner's. The weight g = 1/2 stands for the
    whole gain, as in `covariance`; smaller and larger ones scale it by 2 g, up to one.

    Source: TR, Eq. 14; BOIDS, Eq. 13 to 20.
    """
    for i in range(p.shape[0]):
        if not ended[i] or partner[i] == NOWHERE:
            continue
        for area in range(2):
            if heard_weight[i, area] == 0.0:
                continue
            P, R = moments[i, area], heard_cov[i, area] / heard_weight[i, area]
            x = heard_sum[i, area, 0] / heard_weight[i, area]
            y = heard_sum[i, area, 1] / heard_weight[i, area]
            if not known[i, area]:
                known[i, area] = True
                location[i, area, 0], location[i, area, 1] = x, y
                P[XX], P[XY], P[YY] = R[0], R[1], R[2]
                P[XT] = P[YT] = P[TT] = 0.0
                correlations[i, :, area] = 0.0
                C = correlations[i, partner[i], area]
                C[0, 0], C[0, 1], C[1, 0], C[1, 1] = R[0], R[1], R[1], R[2]
            elif double or area == goal[i]:
                dx, dy = x - location[i, area, 0], y - location[i, area, 1]
                share = min(2.0 * float(g[i, area]), 1.0)
                correct_shared(
                    i, area, partner[i], dx, dy, share, R, location[i, area], P, correlations
                )
            p[i, area] = math.sqrt(max(spectral_norm(P[XX], P[XY], P[YY]), 0.0))
