"""Fast covariance intersection of what a robot and its neighbours believe of its pose.

Smith et al. 2021 (BOIDS), Section 2.2; Fraenken and Huepper 2005.
"""

import math

from baselines.estimators.matrices import (
    Matrix3,
    determinant3,
    inverse3,
    product3,
    product3_transposed,
)
from swarm_forage_env.arrays import Array, Bool, Float32, Float64
from swarm_forage_env.kernels.compiler import kernel
from swarm_forage_env.kernels.frames import wrap


@kernel
def fast_ci_weights(
    inverses: Float64[Array, "L 3 3"],
    n: int,
    scratch: Float64[Array, "2 3 3"],
    out_weights: Float64[Array, " L"],
) -> None:
    """The weights of covariance intersection, in closed form; they sum to one.

        I_q = (P^q)^-1,   S = sum_q I_q
        w_j = (det S - det(S - I_j) + det I_j)
              / (L det S + sum_q [det I_q - det(S - I_q)])

    Of the first n matrices. The paper prints P for its inverse.

    Source: BOIDS, Eq. 4; Fraenken2005, Eq. 16.
    """
    S, rest = scratch[0], scratch[1]
    S[:, :] = 0.0
    for q in range(n):
        S += inverses[q]
    det_S, total = determinant3(S), 0.0
    for j in range(n):
        rest[:, :] = S - inverses[j]
        out_weights[j] = det_S - determinant3(rest) + determinant3(inverses[j])
        total += out_weights[j]
    for j in range(n):
        out_weights[j] /= total


@kernel
def place_of_neighbour(x: float, y: float, far: float, direction: float) -> tuple[float, float]:
    """Where a robot at (x, y) sees another, `far` [m] away in a global direction [rad].

    Source: BOIDS, Eq. 3.
    """
    return x + far * math.cos(direction), y + far * math.sin(direction)


@kernel
def add_sight_noise(
    far: float, direction: float, var_range: float, var_bearing: float,
    scratch: Float64[Array, "2 3 3"], P: Matrix3,
) -> None:  # fmt: skip
    """The covariance of what robot j believes of the pose of a robot it sees, in place.

        P = T P T' + W diag(s_r^2, s_b^2, s_b^2) W'
        T = [1 0 -r sin(d); 0 1 r cos(d); 0 0 1]
        W = [cos(d) -r sin(d) 0; sin(d) r cos(d) 0; 0 1 -1]

    r is the range and d the global direction; the heading is handed on by the bearings at which
    the two see each other. Before, P is that of robot j.

    Source: none; it is the propagation of errors through BOIDS, Eq. 3.
    """
    T, TP = scratch[0], scratch[1]
    T[:, :] = 0.0
    T[0, 0] = T[1, 1] = T[2, 2] = 1.0
    c, s = math.cos(direction), math.sin(direction)
    T[0, 2], T[1, 2] = -far * s, far * c
    product3(T, P, TP)
    product3_transposed(TP, T, P)
    across = far * far * var_bearing
    P[0, 0] += var_range * c * c + across * s * s
    P[1, 1] += var_range * s * s + across * c * c
    P[0, 1] += (var_range - across) * c * s
    P[0, 2] -= var_bearing * far * s
    P[1, 2] += var_bearing * far * c
    P[2, 2] += 2.0 * var_bearing
    P[1, 0], P[2, 0], P[2, 1] = P[0, 1], P[0, 2], P[1, 2]


@kernel
def heard_pose(  # noqa: PLR0913 inputs first, then the outputs
    i: int,
    j: int,
    first: int,
    far: Float32[Array, "rows robots"],
    bearing: Float32[Array, "rows robots"],
    compass: Float32[Array, " rows"],
    numbers: Array,
    pose: Float64[Array, "rows 3"],
    P: Float64[Array, "rows 3 3"],
    scratch: Float64[Array, "2 3 3"],
    out_pose: Float64[Array, "3"],
    out_P: Matrix3,
) -> None:
    """What robot j believes of the pose of robot i, which it sees, and how badly.

    Heading: theta_i = theta_j + b_ji + pi - b_ij, by the bearings at which they see each other.
    In the authors' code a sign slips, so that its global directions are off by the error of the
    heading in the wrong sense; its noise is a diagonal of deviations.
    """
    r, back = float(far[j, i - first]), float(bearing[j, i - first])
    own = float(bearing[i, j - first])
    out_P[:, :] = P[j]
    if numbers[0]["authors"] > 0.0:
        direction = back + 2.0 * float(compass[j]) - pose[j, 2]
        ahead = own + 2.0 * float(compass[i]) - pose[i, 2]
        out_pose[2] = pose[i, 2] - wrap(direction + math.pi - ahead)
        out_P[0, 0] += numbers[0]["range_noise"]
        out_P[1, 1] += numbers[0]["range_noise"]
        out_P[2, 2] += numbers[0]["bearing_noise"]
    else:
        direction = back + pose[j, 2]
        heading = pose[j, 2] + back + math.pi - own
        out_pose[2] = pose[i, 2] + wrap(heading - pose[i, 2])
        var_range, var_bearing = numbers[0]["range_noise"] ** 2, numbers[0]["bearing_noise"] ** 2
        add_sight_noise(r, direction, var_range, var_bearing, scratch, out_P)
    out_pose[0], out_pose[1] = place_of_neighbour(pose[j, 0], pose[j, 1], r, direction)


@kernel
def fuse(  # noqa: PLR0913 inputs first, then the outputs
    n: int,
    inverses: Float64[Array, "L 3 3"],
    poses: Float64[Array, "L 3"],
    weights: Float64[Array, " L"],
    scratch: Matrix3,
    out_pose: Float64[Array, "3"],
    out_P: Matrix3,
) -> None:
    """The weighted intersection of the first n estimates of a pose.

        P = (sum_j w_j I_j)^-1
        x = P sum_j w_j I_j x^j

    Source: BOIDS, Eq. 5.
    """
    scratch[:, :] = 0.0
    vx, vy, vt = 0.0, 0.0, 0.0
    for q in range(n):
        for a in range(3):
            for b in range(3):
                scratch[a, b] += weights[q] * inverses[q, a, b]
        info, x, w = inverses[q], poses[q], weights[q]
        vx += w * (info[0, 0] * x[0] + info[0, 1] * x[1] + info[0, 2] * x[2])
        vy += w * (info[1, 0] * x[0] + info[1, 1] * x[1] + info[1, 2] * x[2])
        vt += w * (info[2, 0] * x[0] + info[2, 1] * x[1] + info[2, 2] * x[2])
    inverse3(scratch, out_P)
    for a in range(3):
        out_pose[a] = out_P[a, 0] * vx + out_P[a, 1] * vy + out_P[a, 2] * vt


@kernel
def intersect(  # noqa: PLR0913 inputs first, then what is updated
    seen: Bool[Array, "rows robots"],
    far: Float32[Array, "rows robots"],
    bearing: Float32[Array, "rows robots"],
    compass: Float32[Array, " rows"],
    g: Float32[Array, "rows 1"],
    numbers: Array,
    said_pose: Float64[Array, "rows 3"],
    said_P: Float64[Array, "rows 3 3"],
    room: Float64[Array, "L 3 3"],
    poses: Float64[Array, "L 3"],
    weights: Float64[Array, " L"],
    scratch: Float64[Array, "2 3 3"],
    pose: Float64[Array, "rows 3"],
    P: Float64[Array, "rows 3 3"],
) -> None:
    """Fuse every robot's estimate with what its neighbours believe of it, in place.

    A correction is carried out to the share g in [0, 1]: the neighbours keep g of their weights
    and the own estimate takes the rest, which is a covariance intersection too. In the authors'
    code a robot with a single neighbour fuses nothing.

    Source: BOIDS, Eq. 3 to 5.
    """
    n_robots = seen.shape[1]
    least = 2 if numbers[0]["authors"] > 0.0 else 1
    for i in range(pose.shape[0]):
        first = i // n_robots * n_robots
        n = 1
        inverse3(said_P[i], room[0])
        poses[0] = said_pose[i]
        for other in range(n_robots):
            j = first + other
            if seen[i, other] and seen[j, i - first]:
                heard_pose(
                    i, j, first, far, bearing, compass, numbers, said_pose, said_P, scratch,
                    poses[n], P[i],
                )  # fmt: skip
                inverse3(P[i], room[n])
                n += 1
        P[i] = said_P[i]
        if n <= least:
            continue
        fast_ci_weights(room, n, scratch, weights)
        share = float(g[i, 0])
        for q in range(n):
            weights[q] *= share
        weights[0] += 1.0 - share
        fuse(n, room, poses, weights, scratch[0], pose[i], P[i])
