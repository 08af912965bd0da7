"""Kernels of the covariance filters, part two: error ellipses told, heard and merged.

A message says after the words of social odometry, for each area: the standard deviation along
the short axis of the error ellipse [m], and the direction of its long axis in the sender's body
frame [rad]. The standard deviation along the long axis is p, told there.
"""

import math

from baselines.estimators.beliefs import NOBODY
from baselines.estimators.conversing import WORDS_PER_AREA, slot_of
from baselines.estimators.uncertainty import TT, XT, XX, XY, YT, YY, spectral_norm
from swarm_forage_env.arrays import Array, Bool, Float32, Float64, Int8, Int32
from swarm_forage_env.kernels.compiler import kernel
from swarm_forage_env.kernels.frames import wrap

FIRST_WORD = 2 * WORDS_PER_AREA
EXTRA_WORDS = 2


@kernel
def to_ellipse(xx: float, xy: float, yy: float) -> tuple[float, float, float]:
    """Standard deviations along the long and the short axis [m], direction of the long [rad].

    The matrix is a covariance of positions [m^2].
    """
    long = spectral_norm(xx, xy, yy)
    short = max(xx + yy - long, 0.0)
    return math.sqrt(long), math.sqrt(short), 0.5 * math.atan2(2.0 * xy, xx - yy)


@kernel
def to_matrix(long: float, short: float, direction: float) -> tuple[float, float, float]:
    """The covariance (xx, xy, yy) [m^2] of the ellipse of these axes [m] and direction [rad]."""
    c, s = math.cos(direction), math.sin(direction)
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


@kernel
def gain(
    axx: float, axy: float, ayy: float, bxx: float, bxy: float, byy: float
) -> tuple[float, float, float, float]:
    """The gain matrix (xx, xy, yx, yy) for an own covariance A and a heard one B.

        K = A (A + B)^-1

    Where A + B has no inverse, the ratio of the norms stands for it; 1/2 where both are 0.

    Source: TR, Eq. 22.
    """
    sxx, sxy, syy = axx + bxx, axy + bxy, ayy + byy
    det = sxx * syy - sxy * sxy
    if det > 1e-12 * (sxx + syy) ** 2:
        return (
            (axx * syy - axy * sxy) / det, (axy * sxx - axx * sxy) / det,
            (axy * syy - ayy * sxy) / det, (ayy * sxx - axy * sxy) / det,
        )  # fmt: skip
    own, heard = spectral_norm(axx, axy, ayy), spectral_norm(bxx, bxy, byy)
    k = own / (own + heard) if own + heard > 0.0 else 0.5
    return k, 0.0, 0.0, k


@kernel
def blend(
    kxx: float, kxy: float, kyx: float, kyy: float,
    P: Float64[Array, "6"], R: Float64[Array, "3"],
) -> None:  # fmt: skip
    """The moments P after taking over K of a heard estimate of covariance R, in place.

        P = L P L' + K R K',  L = I - K of the position, 1 of the heading

    For the gain of Eq. 22 the position's block is (I - K) P: K_j P_i. The heading is not
    corrected, so its variance stays.

    Source: TR, Eq. 24.
    """
    lxx, lxy, lyx, lyy = 1.0 - kxx, -kxy, -kyx, 1.0 - kyy
    xx, xy, yy, xt, yt = P[XX], P[XY], P[YY], P[XT], P[YT]
    rxx, rxy, ryy = R[0], R[1], R[2]
    P[XX] = lxx * lxx * xx + 2.0 * lxx * lxy * xy + lxy * lxy * yy
    P[XX] += kxx * kxx * rxx + 2.0 * kxx * kxy * rxy + kxy * kxy * ryy
    P[XY] = lxx * lyx * xx + (lxx * lyy + lxy * lyx) * xy + lxy * lyy * yy
    P[XY] += kxx * kyx * rxx + (kxx * kyy + kxy * kyx) * rxy + kxy * kyy * ryy
    P[YY] = lyx * lyx * xx + 2.0 * lyx * lyy * xy + lyy * lyy * yy
    P[YY] += kyx * kyx * rxx + 2.0 * kyx * kyy * rxy + kyy * kyy * ryy
    P[XT], P[YT] = lxx * xt + lxy * yt, lyx * xt + lyy * yt


@kernel
def note_ellipses(  # noqa: PLR0913 inputs first, then what is updated
    valid: Bool[Array, "rows slots"],
    sender: Int32[Array, "rows slots"],
    words: Float32[Array, "rows slots words"],
    beam: Float32[Array, "rows slots beam"],
    frames: Int32[Array, "rows slots"],
    before: Int32[Array, " rows"],
    partner: Int32[Array, " rows"],
    pose: Float64[Array, "rows 3"],
    heard_cov: Float64[Array, "rows areas 3"],
) -> None:
    """Add this tick's ellipses to the sums over each conversation, weighted by frames.

    `before` are the partners at the end of the last tick: who ends a conversation in this tick
    has none afterwards.
    """
    for i in range(pose.shape[0]):
        other = before[i] if before[i] != NOBODY else partner[i]
        if other == NOBODY:
            continue
        if before[i] == NOBODY:
            heard_cov[i, :, :] = 0.0
        slot = slot_of(valid[i], sender[i], other)
        if slot == valid.shape[1]:
            continue
        for area in range(2):
            at, more = area * WORDS_PER_AREA, FIRST_WORD + area * EXTRA_WORDS
            told = words[i, slot]
            if told[at] > 0.0:
                psi = heard_direction(beam[i, slot, 1], beam[i, slot, 2], told[more + 1])
                xx, xy, yy = to_matrix(told[at + 3], told[more], psi + pose[i, 2])
                heard_cov[i, area, 0] += frames[i, slot] * xx
                heard_cov[i, area, 1] += frames[i, slot] * xy
                heard_cov[i, area, 2] += frames[i, slot] * yy


@kernel
def tell_ellipses(
    moments: Float64[Array, "rows areas 6"],
    pose: Float64[Array, "rows 3"],
    words: Float32[Array, "rows words"],
) -> None:
    """Add the error ellipse of every area that a message tells of, in place."""
    for i in range(pose.shape[0]):
        for area in range(2):
            more = FIRST_WORD + area * EXTRA_WORDS
            if words[i, area * WORDS_PER_AREA] > 0.0:
                P = moments[i, area]
                _, short, direction = to_ellipse(P[XX], P[XY], P[YY])
                words[i, more], words[i, more + 1] = short, wrap(direction - pose[i, 2])


@kernel
def merge_ellipses(  # noqa: PLR0913 inputs first, then what is updated
    ended: Bool[Array, " rows"],
    g: Float32[Array, "rows areas"],
    double: bool,
    intersects: bool,
    goal: Int8[Array, " rows"],
    heard_sum: Float64[Array, "rows areas 2"],
    heard_weight: Float64[Array, "rows areas"],
    heard_cov: Float64[Array, "rows areas 3"],
    location: Float64[Array, "rows areas 2"],
    p: Float64[Array, "rows areas"],
    known: Bool[Array, "rows areas"],
    moments: Float64[Array, "rows areas 6"],
) -> None:
    """Copy what was unknown; blend what both know, about the goal (single) or both (double).

        x_i = K_j x_i + K_i X_j,  K_j = I - K_i

    The gain weighs the own covariance by g and the heard one by 1 - g. `intersects` takes their
    errors for correlated by an unknown amount: covariance intersection with the weight g, which
    has the same gain, P / (1 - g) for P and R / g for R.

    Source: TR, Eq. 14 and 23; BOIDS, Eq. 5.
    """
    for i in range(p.shape[0]):
        if not ended[i]:
            continue
        for area in range(2):
            if heard_weight[i, area] == 0.0:
                continue
            P, R, place = moments[i, area], heard_cov[i, area] / heard_weight[i, area], location[i]
            x = heard_sum[i, area, 0] / heard_weight[i, area]
            y = heard_sum[i, area, 1] / heard_weight[i, area]
            if not known[i, area]:
                known[i, area] = True
                place[area, 0], place[area, 1] = x, y
                P[XX], P[XY], P[YY] = R[0], R[1], R[2]
                P[XT] = P[YT] = P[TT] = 0.0
            elif double or area == goal[i]:
                w = float(g[i, area])
                u = 1.0 - w
                kxx, kxy, kyx, kyy = gain(
                    w * P[XX], w * P[XY], w * P[YY], u * R[0], u * R[1], u * R[2]
                )
                dx, dy = x - place[area, 0], y - place[area, 1]
                place[area, 0] += kxx * dx + kxy * dy
                place[area, 1] += kyx * dx + kyy * dy
                if intersects and 0.0 < w < 1.0:
                    P[:3] /= u
                    R /= w
                blend(kxx, kxy, kyx, kyy, P, R)
            p[i, area] = math.sqrt(spectral_norm(P[XX], P[XY], P[YY]))
