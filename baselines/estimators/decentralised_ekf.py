"""The decentralised extended Kalman filter: relative updates with stored cross-correlations.

Smith et al. 2021 (BOIDS), Section 2.3; Luft et al. 2016 and 2018.

Robot i keeps its pose x_i, its covariance P_i, and a factor s_ij for every other robot j, so that
P_ij = s_ij s_ji'. All factors start at zero.
"""

import math

from baselines.estimators.matrices import (
    Matrix3,
    cholesky3,
    identity3,
    inverse3,
    product3,
    product3_transposed,
    solve_lower3,
    spectral_norm3,
    symmetrise3,
)
from swarm_forage_env.arrays import Array, Bool, Float32, Float64
from swarm_forage_env.kernels.compiler import kernel
from swarm_forage_env.kernels.frames import wrap

NEAREST = 1e-3
"""Robots believed nearer than this cannot be told apart by a bearing [m] (chosen)."""

COHERENCE = 0.999
"""Most that two robots' errors may be believed to go together, of what is possible (chosen)."""

MAX_JUMP, MAX_GROWTH = 0.5, 1.0
"""The authors' code refuses a correction by as many metres, or that adds as much to |P|."""


@kernel
def sight_jacobian(dx: float, dy: float, by_heading: float, out_G: Float64[Array, "2 6"]) -> None:
    """Derivative of the range and bearing at which i sees j by the poses of both.

        G_i = [-dx/r -dy/r 0; dy/r^2 -dx/r^2 -1],  G_j = [dx/r dy/r 0; -dy/r^2 dx/r^2 0]

    (dx, dy) = x_j - x_i [m]; `by_heading` is -1 for a bearing of the body frame, 0 for a global
    one.

    Source: BOIDS, Eq. 14, whose first block has no heading.
    """
    r2 = dx * dx + dy * dy
    r = math.sqrt(r2)
    out_G[:, :] = 0.0
    out_G[0, 0], out_G[0, 1], out_G[0, 3], out_G[0, 4] = -dx / r, -dy / r, dx / r, dy / r
    out_G[1, 0], out_G[1, 1], out_G[1, 3], out_G[1, 4] = dy / r2, -dx / r2, -dy / r2, dx / r2
    out_G[1, 2] = by_heading


@kernel
def joint_gain(
    joint: Float64[Array, "6 6"],
    G: Float64[Array, "2 6"],
    var_range: float,
    var_bearing: float,
    out_K: Float64[Array, "6 2"],
) -> None:
    """The gain of a relative measurement on the poses of both robots.

        K = P G' (G P G' + R)^-1,  R = diag(var_range, var_bearing)

    Source: BOIDS, Eq. 16.
    """
    for a in range(6):
        for k in range(2):
            out_K[a, k] = 0.0
            for b in range(6):
                out_K[a, k] += joint[a, b] * G[k, b]
    s00, s01, s11 = var_range, 0.0, var_bearing
    for b in range(6):
        s00 += G[0, b] * out_K[b, 0]
        s01 += G[0, b] * out_K[b, 1]
        s11 += G[1, b] * out_K[b, 1]
    scale = 1.0 / (s00 * s11 - s01 * s01)
    for a in range(6):
        k0, k1 = out_K[a, 0], out_K[a, 1]
        out_K[a, 0] = scale * (k0 * s11 - k1 * s01)
        out_K[a, 1] = scale * (k1 * s00 - k0 * s01)


@kernel
def left_over(
    A: Float64[Array, "6 6"],
    G: Float64[Array, "2 6"],
    K: Float64[Array, "6 2"],
    out: Float64[Array, "6 6"],
) -> None:
    """((I - K G) A)', transposed so that doing it twice gives (I - K G) A (I - K G)'."""
    for b in range(6):
        seen_range, seen_bearing = 0.0, 0.0
        for c in range(6):
            seen_range += G[0, c] * A[c, b]
            seen_bearing += G[1, c] * A[c, b]
        for a in range(6):
            out[b, a] = A[a, b] - K[a, 0] * seen_range - K[a, 1] * seen_bearing


@kernel
def corrected_joint(  # noqa: PLR0913 inputs first, then the outputs
    joint: Float64[Array, "6 6"],
    G: Float64[Array, "2 6"],
    K: Float64[Array, "6 2"],
    var_range: float,
    var_bearing: float,
    scratch: Float64[Array, "6 6"],
    out: Float64[Array, "6 6"],
) -> None:
    """The covariance of both after the measurement, for any gain: positive semi-definite.

        P = (I - K G) P (I - K G)' + K R K'

    Source: BucyJoseph1968, for BOIDS, Eq. 17.
    """
    left_over(joint, G, K, scratch)
    left_over(scratch, G, K, out)
    for a in range(6):
        for b in range(a + 1):
            noise = var_range * K[a, 0] * K[b, 0] + var_bearing * K[a, 1] * K[b, 1]
            out[a, b] = out[b, a] = 0.5 * (out[a, b] + out[b, a]) + noise


@kernel
def bound_correlation(
    P_i: Matrix3, P_j: Matrix3, room: Float64[Array, "5 3 3"], C: Matrix3
) -> None:
    """Shrink a cross-covariance, in place, to what the two covariances allow.

        |L_i^-1 C L_j^-T| <= COHERENCE,  L L' = P

    Luft's factors only approximate it once others have corrected either robot, and may claim
    more than two robots can share: then the joint matrix is no covariance.

    Source: HornJohnson2012, Theorem 7.7.7.
    """
    L, half, M, square, turned = room[0], room[1], room[2], room[3], room[4]
    cholesky3(P_i, L)
    solve_lower3(L, C, half)
    for a in range(3):
        for b in range(3):
            turned[a, b] = half[b, a]
    cholesky3(P_j, L)
    solve_lower3(L, turned, M)
    product3_transposed(M, M, square)
    most = math.sqrt(spectral_norm3(square))
    if most > COHERENCE:
        C *= COHERENCE / most


@kernel
def join(P_i: Matrix3, P_j: Matrix3, C: Matrix3, out: Float64[Array, "6 6"]) -> None:
    """The joint covariance [P_i C; C' P_j]."""
    for a in range(3):
        for b in range(3):
            out[a, b] = P_i[a, b]
            out[a, b + 3] = C[a, b]
            out[a + 3, b] = C[b, a]
            out[a + 3, b + 3] = P_j[a, b]


@kernel
def carry_over(
    i: int,
    before: Matrix3,
    after: Matrix3,
    room: Float64[Array, "5 3 3"],
    factors: Float64[Array, "rows robots 3 3"],
) -> None:
    """The factors of robot i, whose covariance was corrected, in place.

        s_ih = P_i+ (P_i-)^-1 s_ih

    Source: BOIDS, Eq. 19 and 20; Luft2018, Eq. 16.
    """
    undo, ratio = room[0], room[1]
    inverse3(before, undo)
    product3(after, undo, ratio)
    multiply_factors(i, ratio, factors)


@kernel
def multiply_factors(i: int, M: Matrix3, factors: Float64[Array, "rows robots 3 3"]) -> None:
    """M s_ih for every robot h, in place; written out, for it is most of a correction's work."""
    for h in range(factors.shape[1]):
        for k in range(3):
            a, b, c = factors[i, h, 0, k], factors[i, h, 1, k], factors[i, h, 2, k]
            factors[i, h, 0, k] = M[0, 0] * a + M[0, 1] * b + M[0, 2] * c
            factors[i, h, 1, k] = M[1, 0] * a + M[1, 1] * b + M[1, 2] * c
            factors[i, h, 2, k] = M[2, 0] * a + M[2, 1] * b + M[2, 2] * c


@kernel
def correct_both(  # noqa: PLR0913 inputs first, then what is updated
    i: int,
    j: int,
    first: int,
    far: float,
    bearing: float,
    g: float,
    numbers: Array,
    room: Float64[Array, "5 3 3"],
    big: Float64[Array, "3 6 6"],
    G: Float64[Array, "2 6"],
    K: Float64[Array, "6 2"],
    pose: Float64[Array, "rows 3"],
    P: Float64[Array, "rows 3 3"],
    factors: Float64[Array, "rows robots 3 3"],
) -> None:
    """Correct robots i and j, and their factors, by how i sees j, in place.

        x = x + g K (z - h(x))
        s_ij = P_ij,  s_ji = I

    Source: BOIDS, Eq. 13 to 20; Luft2018, Section 3.4.
    """
    dx, dy = pose[j, 0] - pose[i, 0], pose[j, 1] - pose[i, 1]
    expected = math.hypot(dx, dy)
    if expected < NEAREST:
        return
    at_i, at_j = i - first, j - first
    C, before_i, before_j = room[4].copy(), P[i].copy(), P[j].copy()
    product3_transposed(factors[i, at_j], factors[j, at_i], C)
    bound_correlation(P[i], P[j], room, C)
    join(P[i], P[j], C, big[0])
    sight_jacobian(dx, dy, -1.0, G)
    var_range, var_bearing = numbers[0]["range_noise"] ** 2, numbers[0]["bearing_noise"] ** 2
    joint_gain(big[0], G, var_range, var_bearing, K)
    K *= g
    corrected_joint(big[0], G, K, var_range, var_bearing, big[1], big[2])
    along = far - expected
    across = wrap(bearing - (math.atan2(dy, dx) - pose[i, 2]))
    for a in range(3):
        pose[i, a] += K[a, 0] * along + K[a, 1] * across
        pose[j, a] += K[a + 3, 0] * along + K[a + 3, 1] * across
        for b in range(3):
            P[i, a, b], P[j, a, b] = big[2, a, b], big[2, a + 3, b + 3]
    pose[i, 2], pose[j, 2] = wrap(pose[i, 2]), wrap(pose[j, 2])
    carry_over(i, before_i, P[i], room, factors)
    carry_over(j, before_j, P[j], room, factors)
    for a in range(3):
        for b in range(3):
            factors[i, at_j, a, b] = big[2, a, b + 3]
    identity3(1.0, factors[j, at_i])


@kernel
def correct_by_sight(  # noqa: PLR0913 inputs first, then what is updated
    seen: Bool[Array, "rows robots"],
    far: Float32[Array, "rows robots"],
    bearing: Float32[Array, "rows robots"],
    g: Float32[Array, "rows 1"],
    numbers: Array,
    room: Float64[Array, "5 3 3"],
    big: Float64[Array, "3 6 6"],
    G: Float64[Array, "2 6"],
    K: Float64[Array, "6 2"],
    pose: Float64[Array, "rows 3"],
    P: Float64[Array, "rows 3 3"],
    factors: Float64[Array, "rows robots 3 3"],
) -> None:
    """Every sight corrects both robots, one after the other in the order of their numbers."""
    n_robots = seen.shape[1]
    for i in range(seen.shape[0]):
        first = i // n_robots * n_robots
        for other in range(n_robots):
            if seen[i, other]:
                correct_both(
                    i, first + other, first, float(far[i, other]), float(bearing[i, other]),
                    float(g[i, 0]), numbers, room, big, G, K, pose, P, factors,
                )  # fmt: skip


@kernel
def correct_privately(  # noqa: PLR0913 inputs first, then what is updated
    at_home: Bool[Array, " rows"],
    fix: Float32[Array, "rows 3"],
    variance: float,
    room: Float64[Array, "5 3 3"],
    pose: Float64[Array, "rows 3"],
    P: Float64[Array, "rows 3 3"],
    factors: Float64[Array, "rows robots 3 3"],
) -> None:
    """Correct those at home by its fix, an unbiased reading of the whole pose, in place.

        K = P (P + R)^-1,  R = variance I
        x = x + K (z - x)
        P = (I - K) P (I - K)' + K R K'
        s_ij = (I - K) s_ij

    Source: BOIDS, Eq. 8 to 12, whose last left side must be s_ij.
    """
    sum_, K, rest, half = room[0], room[1], room[2], room[3]
    for i in range(pose.shape[0]):
        if not at_home[i]:
            continue
        sum_[:, :] = P[i]
        for a in range(3):
            sum_[a, a] += variance
        inverse3(sum_, half)
        product3(P[i], half, K)
        residual = fix[i, 0] - pose[i, 0], fix[i, 1] - pose[i, 1], wrap(fix[i, 2] - pose[i, 2])
        for a in range(3):
            for k in range(3):
                pose[i, a] += K[a, k] * residual[k]
                rest[a, k] = (1.0 if a == k else 0.0) - K[a, k]
        pose[i, 2] = wrap(pose[i, 2])
        product3(rest, P[i], half)
        product3_transposed(half, rest, P[i])
        product3_transposed(K, K, half)
        for a in range(3):
            for b in range(3):
                P[i, a, b] += variance * half[a, b]
        symmetrise3(P[i])
        multiply_factors(i, rest, factors)


@kernel
def bearing_beside(measured: float, expected: float, dy: float) -> float:
    """The expected bearing as the authors' code compares it: with the other sign, if nearer.

    Where |dy| < 1 m the sign of the expected bearing is turned if that brings it nearer to the
    measured one, which stands in for wrapping the difference.

    Source: BOIDS, authors' code.
    """
    if abs(dy) < 1.0 and abs(measured - expected) >= abs(measured + expected):
        return -expected
    return expected


@kernel
def correct_one(  # noqa: PLR0913 inputs first, then what is updated
    i: int,
    j: int,
    first: int,
    far: float,
    direction: float,
    g: float,
    numbers: Array,
    room: Float64[Array, "5 3 3"],
    big: Float64[Array, "3 6 6"],
    G: Float64[Array, "2 6"],
    K: Float64[Array, "6 2"],
    said_pose: Float64[Array, "rows 3"],
    said_P: Float64[Array, "rows 3 3"],
    said_back: Matrix3,
    pose: Float64[Array, "rows 3"],
    P: Float64[Array, "rows 3 3"],
    factors: Float64[Array, "rows robots 3 3"],
) -> None:
    """Correct robot i alone by how it sees j, unless that moves it far, in place.

    The half of robot j is thrown away; `said_back` is its factor for i. Both noises are the
    deviation of the range, and nothing keeps the joint matrix a covariance.

    Source: BOIDS, authors' code.
    """
    dx, dy = said_pose[j, 0] - pose[i, 0], said_pose[j, 1] - pose[i, 1]
    expected = math.hypot(dx, dy)
    if expected == 0.0:
        return
    C, before, after = room[3], room[4].copy(), room[4]
    product3_transposed(factors[i, j - first], said_back, C)
    join(P[i], said_P[j], C, big[0])
    sight_jacobian(dx, dy, 0.0, G)
    noise = numbers[0]["range_noise"]
    joint_gain(big[0], G, noise, noise, K)
    along = far - expected
    across = direction - bearing_beside(direction, math.atan2(dy, dx), dy)
    K *= g
    left_over(big[0], G, K, big[1])
    shift = K[:3, 0] * along + K[:3, 1] * across
    jump = math.hypot(shift[0], shift[1])
    before[:, :] = P[i]
    after[:, :] = big[1, :3, :3].T
    if jump >= MAX_JUMP or spectral_norm3(after) - spectral_norm3(before) >= MAX_GROWTH:
        return
    P[i] = after
    for a in range(3):
        pose[i, a] += shift[a]
    carry_over(i, before, P[i], room, factors)
    factors[i, j - first] = big[1, 3:, :3].T


@kernel
def correct_each_alone(  # noqa: PLR0913 inputs first, then what is updated
    seen: Bool[Array, "rows robots"],
    far: Float32[Array, "rows robots"],
    bearing: Float32[Array, "rows robots"],
    compass: Float32[Array, " rows"],
    g: Float32[Array, "rows 1"],
    numbers: Array,
    room: Float64[Array, "5 3 3"],
    big: Float64[Array, "3 6 6"],
    G: Float64[Array, "2 6"],
    K: Float64[Array, "6 2"],
    said_pose: Float64[Array, "rows 3"],
    said_P: Float64[Array, "rows 3 3"],
    said_factors: Float64[Array, "rows robots 3 3"],
    pose: Float64[Array, "rows 3"],
    P: Float64[Array, "rows 3 3"],
    factors: Float64[Array, "rows robots 3 3"],
) -> None:
    """Every robot corrects itself by all that it sees, all from what was said before.

    Its global directions are off by the error of its heading in the wrong sense.

    Source: BOIDS, authors' code.
    """
    n_robots = seen.shape[1]
    for i in range(seen.shape[0]):
        first = i // n_robots * n_robots
        turned = 2.0 * float(compass[i]) - said_pose[i, 2]
        for other in range(n_robots):
            if seen[i, other]:
                j = first + other
                direction = wrap(float(bearing[i, other]) + turned)
                correct_one(
                    i, j, first, float(far[i, other]), direction, float(g[i, 0]),
                    numbers, room, big, G, K, said_pose, said_P, said_factors[j, i - first],
                    pose, P, factors,
                )  # fmt: skip
