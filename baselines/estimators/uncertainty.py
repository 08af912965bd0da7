"""Kernels of the covariance filters, part one: how uncertainty grows with the path.

Moments are the six numbers of a symmetric 3 x 3 covariance of a pose: (xx, xy, yy) [m^2],
(xt, yt) [m rad] and tt [rad^2], t being the heading; in the robot's own frame.
"""

import math

from swarm_forage_env.arrays import Array, Float32, Float64, Int8
from swarm_forage_env.kernels.compiler import kernel

XX, XY, YY, XT, YT, TT = range(6)
N_MOMENTS = 6


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
def carry(P: Float64[Array, "6"], drho: float, zeta: float) -> None:
    """The moments P after a step of drho [m] in direction zeta [rad], encoders exact; in place.

        P = A P A'
        A = [1 0 -drho sin(zeta); 0 1 drho cos(zeta); 0 0 1]

    Source: TR, Eq. 9 and 11.
    """
    u, v = -drho * math.sin(zeta), drho * math.cos(zeta)
    P[XX] += 2.0 * u * P[XT] + u * u * P[TT]
    P[XY] += u * P[YT] + v * P[XT] + u * v * P[TT]
    P[YY] += 2.0 * v * P[YT] + v * v * P[TT]
    P[XT] += u * P[TT]
    P[YT] += v * P[TT]


@kernel
def add_noise(
    P: Float64[Array, "6"], drho: float, zeta: float, q_r: float, q_l: float, axle: float
) -> None:
    """Add to the moments P what encoders of variance q_r and q_l [m^2] bring, in place.

        P = P + W Q W',  Q = diag(q_r, q_l)
        W = [ c / 2 - e s    c / 2 + e s
              s / 2 + e c    s / 2 - e c
              1 / b          -1 / b      ]

    c, s = cos(zeta), sin(zeta) of the step's direction [rad]; e = drho / (2 b); b = axle [m].

    Source: TR, Eq. 9 and 11.
    """
    c, s = 0.5 * math.cos(zeta), 0.5 * math.sin(zeta)
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
    return 0.5 * (xx + yy) + math.hypot(0.5 * (xx - yy), xy)


@kernel
def spread(  # noqa: PLR0913 inputs first, then what is updated
    odometry: Float32[Array, "rows 2"],
    axle: float,
    k: float,
    pose: Float64[Array, "rows 3"],
    on_area: Int8[Array, " rows"],
    moments: Float64[Array, "rows areas 6"],
    p: Float64[Array, "rows areas"],
) -> None:
    """Let the covariance since each area grow by a step that led to `pose`; none on the area.

    p is the standard deviation along the worst direction: p^2 = |P| of the position [m^2].

    Source: TR, Eq. 10 and 32.
    """
    for i in range(pose.shape[0]):
        drho, dtheta = float(odometry[i, 0]), float(odometry[i, 1])
        q_r, q_l = k * abs(drho + 0.5 * axle * dtheta), k * abs(drho - 0.5 * axle * dtheta)
        zeta = pose[i, 2] - 0.5 * dtheta
        for area in range(2):
            P = moments[i, area]
            if on_area[i] == area:
                P[:] = 0.0
            else:
                carry(P, drho, zeta)
                add_noise(P, drho, zeta, q_r, q_l, axle)
            p[i, area] = math.sqrt(spectral_norm(P[XX], P[XY], P[YY]))
