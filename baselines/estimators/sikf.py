"""The Social Induced Kalman Filter: social odometry whose confidence is a covariance's norm.

Gutierrez et al. 2009 (TR), Sections 3.3 and 4.2.

Not in the paper, and chosen here:
- the norm is that of the position's 2 x 2 block: the pose's 3 x 3 matrix mixes metres and
  radians;
- in layers and messages p is the root of the norm, the standard deviation [m] in the worst
  direction, so that p is a length as in every other controller;
- the error constants match the encoders of the scenario at the cruise speed;
- after an exchange the whole matrix is scaled by 1 - g, so that its norm follows Eq. 35;
- a robot that copies an estimate receives only the norm of its covariance, so the copy is
  isotropic, and its heading counts as exact from there on;
- the error of the measured beam enters nowhere, as in the paper;
- all that `social_odometry` chose.
"""

import math
from collections.abc import Mapping
from typing import ClassVar, Self

from pydantic import model_validator

from baselines.estimators.base import ESTIMATORS
from baselines.estimators.message_exchange import is_merged, merge_area
from baselines.estimators.path_covariance import (
    N_MOMENTS,
    XX,
    YY,
    CovarianceBelief,
    CovarianceMind,
    error_constant,
    update_belief,
)
from baselines.estimators.social_odometry import KERNELS, SocialOdometryParameters
from swarm_forage_env.arrays import Array
from swarm_forage_env.compiler import kernel
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.interface import Kernel
from swarm_forage_env.record import Numbers


@kernel
def scale_covariance(belief: CovarianceBelief, area: int, kept: float) -> float:
    """Scale the covariance of an area by `kept` = 1 - g, in place; p afterwards [m].

        P_i = (1 - g) P_i, hence |P_i| = (1 - g) |P_i|

    Source: TR, Eq. 35.
    """
    for moment in range(N_MOMENTS):
        belief.moments[area, moment] *= kept
    return float(belief.p[area] * math.sqrt(kept))


@kernel
def merge(mind: CovarianceMind, shared: Array, heard_p_share: float, numbers: Numbers) -> None:
    """Blend what was heard with weight g, which also scales the covariance; or copy both.

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
        paths = self.model_dump(include={"message_path", "tells_within", "listens_above"})
        for name, path in paths.items():
            if path:
                raise ValueError(
                    f"{name}: is a path, and this estimator tells covariances; use it with"
                    " social_odometry, as in ssgiff"
                )
        if self.payload != "float32":
            raise ValueError(
                f"payload={self.payload}: rounds paths, and this estimator tells covariances; use"
                " it with social_odometry, as in ssgiff"
            )
        return self

    def numbers(self, scenario: Scenario) -> dict[str, float]:
        """The parameters as kernels read them, and the error constant of the encoders."""
        noise, cruise = scenario.sensors.wheel_noise, scenario.robot.cruise_speed
        k = error_constant(noise, cruise, scenario.tick)
        return {**super().numbers(scenario), "error_constant": k}


@ESTIMATORS.register("sikf")
class SIKFParameters(CovarianceFilterParameters):
    """Social odometry whose robots exchange the norm of a covariance."""

    kernels: ClassVar[Mapping[str, Kernel]] = {**CovarianceFilterParameters.kernels, "merge": merge}
