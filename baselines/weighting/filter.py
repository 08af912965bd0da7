"""The filter's own gain: a correction is made as the estimator computes it."""

from typing import ClassVar

from baselines.weighting.base import WEIGHTING_RULES
from swarm_forage_env.interface import WeightingLayer
from swarm_forage_env.parameters import Parameters


@WEIGHTING_RULES.register("filter")
class Filter(Parameters):
    """The gain that belongs to the estimator, whichever it is.

    Where robots visit waypoints, the whole correction: g = 1. Where they forage, the rule of
    social odometry, of covariance intersection or of the Kalman filter, as the estimator says.

    Source: BOIDS, Section 2.
    """

    tasks: ClassVar[tuple[str, ...]] = ("foraging", "waypoints", "epuck")

    def layer(self, scenario: object) -> WeightingLayer | None:
        """None: that of the estimator."""
        return None
