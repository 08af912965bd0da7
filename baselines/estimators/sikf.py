"""The Social Induced Kalman Filter: social odometry whose confidence is a covariance's norm.

Gutierrez et al. 2009 (TR), Sections 3.3 and 4.2.

Not in the paper, and chosen here:
- the norm is that of the position's 2 x 2 block: the pose's 3 x 3 matrix mixes metres and
  radians;
- layers and messages are shown the root of the norm, the standard deviation [m] in the worst
  direction, so that p is a length as in every other controller;
- the error constants match the encoders of the scenario at the cruise speed;
- after an exchange the whole matrix is scaled by 1 - g, so that its norm follows Eq. 35;
- whoever copies an estimate knows its norm alone: it is uncertain alike in all directions, and
  the heading counts as exact from there on;
- the error of the measured beam enters nowhere, as in the paper;
- all that `social_odometry` chose.
"""

from typing import Self

import numpy as np
from pydantic import model_validator

from baselines.estimators.base import ESTIMATORS
from baselines.estimators.social_odometry import SocialOdometry, SocialOdometryParameters
from baselines.estimators.uncertainty import N_MOMENTS, XX, YY, error_constant, spread
from swarm_forage_env.arrays import Array, Float32, Float64
from swarm_forage_env.interface import Readings
from swarm_forage_env.scenario import Scenario


class UncertainParameters(SocialOdometryParameters):
    """What social odometry leaves open, where p is no path."""

    @model_validator(mode="after")
    def _no_path(self) -> Self:
        for name in ("message_path", "tells_within", "listens_above"):
            if getattr(self, name):
                raise ValueError(
                    f"{name}: is a path, and this estimator tells covariances; use it with"
                    " social_odometry, as in ssgiff"
                )
        return self


@ESTIMATORS.register("sikf")
class SIKFParameters(UncertainParameters):
    """What social odometry leaves open; the covariance follows from the scenario."""

    def start(self, scenario: Scenario, n_worlds: int) -> "InducedKalman":
        """The running estimator of a block of worlds."""
        return InducedKalman(self, scenario, n_worlds)


class Uncertain(SocialOdometry):
    """Estimates that carry a covariance for each area since it was left."""

    def __init__(
        self, parameters: SocialOdometryParameters, scenario: Scenario, n_worlds: int
    ) -> None:
        """Robots that know nothing yet."""
        super().__init__(parameters, scenario, n_worlds)
        rows = len(self.beliefs.pose)
        self.moments: Float64[Array, "rows areas 6"] = np.zeros((rows, 2, N_MOMENTS))
        noise, cruise = scenario.sensors.wheel_noise, scenario.robot.cruise_speed
        self._k = error_constant(noise, cruise, scenario.tick)

    def reset(self, world: int, seed: int) -> None:
        """Forget everything about one world."""
        super().reset(world, seed)
        self.moments[world * self._n_robots : (world + 1) * self._n_robots] = 0.0

    def _reckon(self, readings: Readings) -> Readings:
        """Move, find areas, and let the covariances grow."""
        readings = super()._reckon(readings)
        b = self.beliefs
        spread(readings.odometry, self._axle, self._k, b.pose, b.on_area, self.moments, b.p)
        return readings


class InducedKalman(Uncertain):
    """The estimates of all robots of a block of worlds."""

    def merge(self, g: Float32[Array, "rows areas"], heard_p_share: float) -> None:
        """Blend what was heard with weight g, which also scales the covariance; or copy it.

            x_i = (1 - g) x_i + g X_j
            P_i = (1 - g) P_i, hence |P_i| = (1 - g) |P_i|

        Source: TR, Eq. 14, 34 and 35.
        """
        before, b, e = self.beliefs.p.copy(), self.beliefs, self.encounter
        super().merge(g, heard_p_share)
        blended = e.own_known & e.heard_known
        if not self.parameters.double:
            blended &= np.arange(2) == b.goal[:, None]
        kept = np.where(blended, 1.0 - g.astype(np.float64), 1.0)
        self.moments *= kept[:, :, None]
        b.p[:] = before * np.sqrt(kept)
        copied = e.heard_known & ~e.own_known
        self.moments[copied] = 0.0
        variance = b.heard_p[copied] ** 2
        self.moments[copied, XX] = variance
        self.moments[copied, YY] = variance
        b.p[copied] = b.heard_p[copied]
