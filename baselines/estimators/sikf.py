"""Social Induced Kalman Filter: social odometry with the norm of a covariance as confidence.

Gutierrez et al. 2009 (TR), Sections 3.3 and 4.2. Moments are the six entries of a symmetric 3 x 3
covariance of a pose: (xx, xy, yy) [m^2], (xt, yt) [m rad] and tt [rad^2], t being the heading; in
the robot's own frame.

Not in the paper, and chosen here:
- the norm is that of the position's 2 x 2 block: the pose's 3 x 3 matrix mixes metres and
  radians;
- in layers and messages p is the root of the norm, the standard deviation [m] in the worst
  direction, so that p is a length as in every other controller;
- the error constants match the encoders of the scenario at the cruise speed;
- after an exchange the whole matrix is scaled by 1 - g, so that its norm follows Eq. 35;
- a robot that copies an estimate receives only the norm of its covariance, so the copy is
  isotropic, and its heading then counts as exact;
- the error of the measured beam is ignored, as in the paper;
- all choices of `social_odometry`.
"""

import math
from collections.abc import Mapping
from typing import ClassVar, Self

import numpy as np
from pydantic import model_validator

from baselines.estimators.area_memory import update_belief as update_social_belief
from baselines.estimators.base import ESTIMATORS
from baselines.estimators.belief import Belief, SocialMind
from baselines.estimators.message_exchange import is_merged, merge_area
from baselines.estimators.social_odometry import KERNELS, SocialOdometryParameters
from swarm_forage_env.arrays import Array, Float32, Float64
from swarm_forage_env.compiler import kernel
from swarm_forage_env.epuck.records import Readings
from swarm_forage_env.equations.elementary import cos_sin, hypot
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.interface import Kernel
from swarm_forage_env.record import Numbers, field

XX, XY, YY, XT, YT, TT = range(6)
N_MOMENTS = 6

Moments = Float64[Array, "6"]

Matrix = tuple[float, float, float]
"""The symmetric 2 x 2 covariance of a position: xx, xy, yy [m^2]."""


class CovarianceBelief(Belief):
    """Belief with the covariance of the pose since each area.

    `p` is the standard deviation of the position along the worst direction [m].
    """

    moments: Float64[Array, "areas 6"] = field(np.float64, 2, N_MOMENTS, unit="m^2, m rad, rad^2")
    """Covariance of the pose since each area."""


class CovarianceMind(SocialMind):
    """State of a robot under a covariance filter."""

    belief: CovarianceBelief = field(CovarianceBelief)


def error_constant(wheel_noise: float, cruise_speed: float, tick: float) -> float:
    """Return the error constant k [m] of Q = diag(k |dU_r|, k |dU_l|) that matches the encoders.

        k = (a v dt)^2 / (3 v dt) = a^2 v dt / 3

    The error of an encoder is uniform in +- a v dt, of variance (a v dt)^2 / 3, for any path of
    its wheel; k matches it at the path v dt of the cruise speed v. a is `wheel_noise`.

    Source: TR, Eq. 10, for Q; ANTS, Section 4.1, for the noise.

    >>> round(error_constant(0.3, 0.1, 1.0), 6)
    0.003
    """
    return wheel_noise**2 * cruise_speed * tick / 3.0


@kernel
def propagate(P: Moments, drho: float, zeta: float) -> None:
    """Propagate the moments P by a noise-free step of drho [m] in direction zeta [rad], in place.

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
    """Add the noise of encoders of variance q_r and q_l [m^2] to the moments P, in place.

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
    for sign, q in ((1.0, q_r), (-1.0, q_l)):
        x, y, t = c - sign * e * s, s + sign * e * c, sign / axle
        P[XX] += q * x * x
        P[XY] += q * x * y
        P[YY] += q * y * y
        P[XT] += q * x * t
        P[YT] += q * y * t
        P[TT] += q * t * t


@kernel
def spectral_norm(xx: float, xy: float, yy: float) -> float:
    """Return the largest eigenvalue of a symmetric, positive 2 x 2 matrix.

    Source: TR, Eq. 27.

    >>> spectral_norm(2.0, 0.0, 3.0)
    3.0
    """
    return 0.5 * (xx + yy) + hypot(0.5 * (xx - yy), xy)


@kernel
def worst_deviation(P: Moments) -> float:
    """Return the standard deviation of the position along the worst direction [m]: p^2 = |P|."""
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
    """Update the belief as social odometry does, and grow the covariances."""
    update_social_belief(mind, shared, readings, numbers)
    grow_covariances(mind.belief, readings.odometry, numbers)


@kernel
def scale_covariance(belief: CovarianceBelief, area: int, factor: float) -> float:
    """Scale the covariance of an area by `factor` = 1 - g, in place; return p after it [m].

        P_i = (1 - g) P_i, hence |P_i| = (1 - g) |P_i|

    Source: TR, Eq. 35.
    """
    for moment in range(N_MOMENTS):
        belief.moments[area, moment] *= factor
    return float(belief.p[area] * math.sqrt(factor))


@kernel
def merge(mind: CovarianceMind, shared: Array, heard_p_share: float, numbers: Numbers) -> None:
    """Blend the heard estimate with weight g and scale the covariance by 1 - g; or copy both.

        x_i = (1 - g) x_i + g X_j,  or P_i = |P_j| I

    Source: TR, Eq. 14, 34 and 35.
    """
    belief = mind.belief
    for area in range(2):
        if is_merged(belief, area, numbers):
            g = float(mind.exchange.weight[area])
            if belief.known[area]:
                p = scale_covariance(belief, area, 1.0 - g)
            else:
                p = float(belief.heard_p[area])
                for moment in range(N_MOMENTS):
                    belief.moments[area, moment] = 0.0
                belief.moments[area, XX] = belief.moments[area, YY] = p * p
            merge_area(belief, area, g, heard_p_share)
            belief.p[area] = p


class CovarianceFilterParameters(SocialOdometryParameters):
    """Social odometry in which p is a standard deviation instead of a path."""

    mind = CovarianceMind
    kernels: ClassVar[Mapping[str, Kernel]] = {**KERNELS, "update_belief": update_belief}

    @model_validator(mode="after")
    def _no_path(self) -> Self:
        for name in ("message_path", "tells_within", "listens_above", "payload"):
            if getattr(self, name) != type(self).model_fields[name].default:
                raise ValueError(
                    f"{name}: applies to path lengths, but this estimator exchanges covariances;"
                    " use it with social_odometry, as in ssgiff"
                )
        return self

    def numbers(self, scenario: Scenario) -> dict[str, float]:
        """Return the parameters of the kernels, with the error constant of the encoders."""
        noise, cruise = scenario.sensors.wheel_noise, scenario.robot.cruise_speed
        k = error_constant(noise, cruise, scenario.tick)
        return {**super().numbers(scenario), "error_constant": k}


@ESTIMATORS.register("sikf")
class SIKFParameters(CovarianceFilterParameters):
    """Social odometry in which robots exchange the norm of a covariance."""

    kernels: ClassVar[Mapping[str, Kernel]] = {**CovarianceFilterParameters.kernels, "merge": merge}
