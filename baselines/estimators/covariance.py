"""Covariance knowledge: social odometry that exchanges and merges whole error ellipses.

Gutierrez et al. 2008 (ANTS), Section 5; Gutierrez et al. 2009 (TR), Eqs. 9-11 and 22-24. A message
contains the standard deviation along the long axis of the error ellipse as p, that along the short
axis, and the direction of the long axis.

Not in the paper, and chosen here:
- matrices are 2 x 2, of the position. An exchange corrects the position only: the variance of the
  heading is unchanged and still feeds the growth of the position's covariance;
- the matrix is sent as an error ellipse, rotated between frames by the measured bearings like the
  direction of the area, and averaged over the exchange like the location;
- a robot that copies an estimate copies its matrix, and its heading then counts as exact;
- where the sum of two matrices has no inverse, their norms are compared;
- the error of the measured beam is ignored, as in the paper;
- the error constants match the encoders of the scenario at the cruise speed;
- one area is exchanged, as in SSGIKF, unless `double`;
- all choices of `social_odometry`.
"""

import math
from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from baselines.estimators.base import ESTIMATORS
from baselines.estimators.belief import NOBODY, Message
from baselines.estimators.falsified_messages import falsify, repeat
from baselines.estimators.message_exchange import compose as compose_places
from baselines.estimators.message_exchange import heard_place, is_merged, slot_of, update_exchange
from baselines.estimators.sikf import (
    TT,
    XT,
    XX,
    XY,
    YT,
    YY,
    CovarianceBelief,
    CovarianceFilterParameters,
    CovarianceMind,
    Matrix,
    Moments,
    spectral_norm,
    worst_deviation,
)
from baselines.weighting.covariance import Covariance
from swarm_forage_env.arrays import Array, Float32, Float64
from swarm_forage_env.compiler import kernel
from swarm_forage_env.epuck.fault_record import Lie
from swarm_forage_env.epuck.records import Heard
from swarm_forage_env.equations.elementary import atan2, cos_sin
from swarm_forage_env.equations.geometry import wrap
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.interface import Kernel
from swarm_forage_env.record import Numbers, field

Gain = tuple[float, float, float, float]  # a 2 x 2 gain matrix: xx, xy, yx, yy


class EllipseMessage(Message):
    """Message with the error ellipse of each area. Writer: `compose`."""

    short_axis: Float32[Array, " areas"] = field(np.float32, 2, unit="m")
    """Standard deviation along the short axis; that along the long axis is `p`."""
    long_direction: Float32[Array, " areas"] = field(np.float32, 2, unit="rad")
    """Direction of the long axis in the body frame of the sender."""


class EllipseBelief(CovarianceBelief):
    """Belief with the error ellipses heard in an exchange."""

    heard_cov: Float64[Array, "areas 3"] = field(np.float64, 2, 3, unit="m^2")
    """Sum of the heard covariances (xx, xy, yy) in the exchange, own frame, weighted by frames."""


class EllipseMind(CovarianceMind):
    """State of a robot with a filter that exchanges covariances."""

    belief: EllipseBelief = field(EllipseBelief)
    message: EllipseMessage = field(EllipseMessage)
    stale_message: EllipseMessage = field(EllipseMessage)


@kernel
def to_ellipse(xx: float, xy: float, yy: float) -> tuple[float, float, float]:
    """Return the long and the short axis [m] and the direction of the long axis [rad].

    The axes are standard deviations; the matrix is the covariance of a position [m^2].
    """
    long = spectral_norm(xx, xy, yy)
    short = max(xx + yy - long, 0.0)
    return math.sqrt(long), math.sqrt(short), 0.5 * atan2(2.0 * xy, xx - yy)


@kernel
def to_matrix(long: float, short: float, direction: float) -> Matrix:
    """Return the covariance (xx, xy, yy) [m^2] of an ellipse: axes [m], direction [rad]."""
    c, s = cos_sin(direction)
    u, v = long * long, short * short
    return u * c * c + v * s * s, (u - v) * c * s, u * s * s + v * c * c


@kernel
def heard_direction(gamma_i: float, gamma_j: float, psi_j: float) -> float:
    """Return a direction psi_j of the sender's body frame in the receiver's body frame [rad].

        psi_i = gamma_i + (psi_j - gamma_j) - pi

    gamma_i, gamma_j are the bearings of the beam at the receiver and at the sender [rad].

    Source: TR, Section 5.2 (before Eq. 40).
    """
    return gamma_i + (psi_j - gamma_j) - math.pi


@kernel
def compose(mind: EllipseMind, numbers: Numbers) -> None:
    """Write the message: the location and the error ellipse of each area."""
    compose_places(mind, numbers)
    belief, message = mind.belief, mind.message
    for area in range(2):
        if message.has_estimate[area]:
            P = belief.moments[area]
            _, short, direction = to_ellipse(P[XX], P[XY], P[YY])
            message.short_axis[area] = short
            message.long_direction[area] = wrap(direction - belief.pose[2])


@kernel
def accumulate_ellipse(
    belief: EllipseBelief, message: EllipseMessage, heard: Heard, slot: int
) -> None:
    """Add the error ellipses of a message to the running sums of an exchange."""
    beam, weight = heard.range_bearing[slot], float(heard.n_averaged[slot])
    for area in range(2):
        if message.has_estimate[area]:
            psi = heard_direction(beam[1], beam[2], message.long_direction[area])
            long, short = message.p[area], message.short_axis[area]
            xx, xy, yy = to_matrix(long, short, psi + belief.pose[2])
            belief.heard_cov[area, 0] += weight * xx
            belief.heard_cov[area, 1] += weight * xy
            belief.heard_cov[area, 2] += weight * yy


@kernel
def update_ellipse_exchange(minds: Array, i: int, heard: Heard, numbers: Numbers) -> bool:
    """Start, continue or end the exchange of robot i, with ellipses; return whether it ended."""
    belief = minds[i].belief
    was_alone = belief.partner == NOBODY
    has_ended = update_exchange(minds, i, heard, numbers)
    if was_alone:
        if belief.partner == NOBODY:
            return False
        for area in range(2):
            for entry in range(3):
                belief.heard_cov[area, entry] = 0.0
    slot = slot_of(heard, belief.last_partner)
    if slot < heard.n:
        accumulate_ellipse(belief, minds[belief.last_partner].message, heard, slot)
    return has_ended


@kernel
def heard_covariance(belief: EllipseBelief, area: int) -> Matrix:
    """Return the mean of the covariances of an area heard in the exchange."""
    cov, weight = belief.heard_cov[area], belief.heard_weight[area]
    return cov[0] / weight, cov[1] / weight, cov[2] / weight


@kernel
def gain_matrix(A: Matrix, B: Matrix) -> Gain:
    """Return the gain matrix for an own covariance A and a heard one B.

        K = A (A + B)^-1

    Where A + B is singular, the ratio of the norms replaces it; 1/2 where both are 0.

    Source: TR, Eq. 22.
    """
    axx, axy, ayy = A
    sxx, sxy, syy = axx + B[0], axy + B[1], ayy + B[2]
    det = sxx * syy - sxy * sxy
    if det > 1e-12 * (sxx + syy) * (sxx + syy):
        return (
            (axx * syy - axy * sxy) / det, (axy * sxx - axx * sxy) / det,
            (axy * syy - ayy * sxy) / det, (ayy * sxx - axy * sxy) / det,
        )  # fmt: skip
    own, heard = spectral_norm(axx, axy, ayy), spectral_norm(B[0], B[1], B[2])
    k = own / (own + heard) if own + heard > 0.0 else 0.5
    return k, 0.0, 0.0, k


@kernel
def blend(K: Gain, P: Moments, R: Matrix) -> None:
    """Correct the moments P with the gain K for a heard covariance R, in place.

        P = L P L' + K R K',  L = I - K of the position, 1 of the heading

    For the gain of Eq. 22, the block of the position is (I - K) P = K_j P_i. The heading is not
    corrected, so its variance is unchanged.

    Source: TR, Eq. 24.
    """
    kxx, kxy, kyx, kyy = K
    lxx, lxy, lyx, lyy = 1.0 - kxx, -kxy, -kyx, 1.0 - kyy
    xx, xy, yy, xt, yt = P[XX], P[XY], P[YY], P[XT], P[YT]
    rxx, rxy, ryy = R
    P[XX] = lxx * lxx * xx + 2.0 * lxx * lxy * xy + lxy * lxy * yy
    P[XX] += kxx * kxx * rxx + 2.0 * kxx * kxy * rxy + kxy * kxy * ryy
    P[XY] = lxx * lyx * xx + (lxx * lyy + lxy * lyx) * xy + lxy * lyy * yy
    P[XY] += kxx * kyx * rxx + (kxx * kyy + kxy * kyx) * rxy + kxy * kyy * ryy
    P[YY] = lyx * lyx * xx + 2.0 * lyx * lyy * xy + lyy * lyy * yy
    P[YY] += kyx * kyx * rxx + 2.0 * kyx * kyy * rxy + kyy * kyy * ryy
    P[XT], P[YT] = lxx * xt + lxy * yt, lyx * xt + lyy * yt


@kernel
def move_location(belief: EllipseBelief, area: int, K: Gain) -> None:
    """Move the location of an area towards the heard one with the gain K, in place.

        x_i = x_i + K (X_j - x_i)

    Source: TR, Eq. 23.
    """
    place, (x, y) = belief.location[area], heard_place(belief, area)
    dx, dy = x - place[0], y - place[1]
    place[0] += K[0] * dx + K[1] * dy
    place[1] += K[2] * dx + K[3] * dy


@kernel
def copy_ellipse(belief: EllipseBelief, area: int, R: Matrix) -> None:
    """Copy the heard location of an unknown area and its covariance R. Source: TR, Eq. 14."""
    belief.known[area] = True
    belief.location[area, 0], belief.location[area, 1] = heard_place(belief, area)
    P = belief.moments[area]
    P[XX], P[XY], P[YY] = R
    P[XT] = P[YT] = P[TT] = 0.0


@kernel
def blend_ellipse(belief: EllipseBelief, area: int, R: Matrix, w: float, intersects: bool) -> None:
    """Blend both estimates of an area; the gain weights the own covariance by w, R by 1 - w.

    With `intersects`, the update is a covariance intersection of weight w, for errors of unknown
    correlation: the same gain, with P / (1 - w) for P and R / w for R.

    Source: TR, Eq. 22 to 24; BOIDS, Eq. 1 and 2.
    """
    P, u = belief.moments[area], 1.0 - w
    own = w * P[XX], w * P[XY], w * P[YY]
    K = gain_matrix(own, (u * R[0], u * R[1], u * R[2]))
    move_location(belief, area, K)
    if intersects and 0.0 < w < 1.0:
        P[XX], P[XY], P[YY] = P[XX] / u, P[XY] / u, P[YY] / u
        R = R[0] / w, R[1] / w, R[2] / w
    blend(K, P, R)


@kernel
def merge(mind: EllipseMind, shared: Array, heard_p_share: float, numbers: Numbers) -> None:
    """Copy heard estimates of unknown areas; blend those of known ones, with the gain for g."""
    belief = mind.belief
    for area in range(2):
        if is_merged(belief, area, numbers):
            R = heard_covariance(belief, area)
            if belief.known[area]:
                g = float(mind.exchange.weight[area])
                blend_ellipse(belief, area, R, g, numbers.intersects > 0.0)
            else:
                copy_ellipse(belief, area, R)
            belief.p[area] = worst_deviation(belief.moments[area])


@kernel
def falsify_ellipse(mind: EllipseMind, lie: Lie) -> None:
    """Replace the locations, p and ellipses of a robot's message by those of a lie."""
    falsify(mind, lie)
    for area in range(2):
        if mind.message.has_estimate[area]:
            mind.message.short_axis[area] = mind.message.p[area]


@kernel
def repeat_ellipse(mind: EllipseMind) -> None:
    """Replace the message by the stale one, ellipses included; without one, keep the message."""
    if repeat(mind):
        turned = mind.stale_pose[2] - mind.belief.pose[2]
        for area in range(2):
            direction = mind.stale_message.long_direction[area] + turned
            mind.message.long_direction[area] = wrap(direction)


@ESTIMATORS.register("covariance")
class CovarianceParameters(CovarianceFilterParameters):
    """Social odometry in which robots exchange error ellipses."""

    mind = EllipseMind
    kernels: ClassVar[Mapping[str, Kernel]] = {
        **CovarianceFilterParameters.kernels,
        "compose": compose,
        "repeat": repeat_ellipse,
        "falsify": falsify_ellipse,
        "update_exchange": update_ellipse_exchange,
        "merge": merge,
    }
    own_rule = Covariance()

    def numbers(self, scenario: Scenario) -> dict[str, float]:
        """Return the parameters of the kernels; estimates are fused as if independent."""
        return {**super().numbers(scenario), "intersects": 0.0}
