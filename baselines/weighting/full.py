"""The estimator's own weighting: what the filter says is done."""

from typing import Any, ClassVar

import numpy as np

from baselines.weighting.base import WEIGHTING_RULES
from baselines.weighting.sgikf import SGIKF
from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.interface import Encounter
from swarm_forage_env.scenario import Part, Scenario
from swarm_forage_env.waypoints_interface import Correction
from swarm_forage_env.waypoints_scenario import WaypointsScenario


@WEIGHTING_RULES.register("full")
class Full(Part):
    """Every correction is carried out as the filter computes it.

        g_i = 1

    Where robots forage, the weighting that goes with the estimator takes its place (`beside`):
    that of social odometry, of covariance intersection or of the Kalman filter.

    Source: BOIDS, Section 2.
    """

    worlds: ClassVar[tuple[type[Part], ...]] = (Scenario, WaypointsScenario)
    heard_p_share: ClassVar[float] = 0.0

    def __call__(self, encounter: Correction | Encounter) -> Float32[Array, "rows weights"]:
        """g for each row; that of SGIKF for an encounter of robots that forage."""
        if isinstance(encounter, Encounter):
            return SGIKF()(encounter)
        return np.ones((len(encounter.valid), 1), np.float32)

    def beside(self, estimator: Any) -> Any:  # noqa: ANN401 of either world
        """The rule that goes with an estimator."""
        return getattr(estimator, "own_rule", self)
