"""Weighting by the gain of the estimator itself."""

from typing import ClassVar

from baselines.weighting.base import WEIGHTING_RULES
from swarm_forage_env.interface import WeightingLayer
from swarm_forage_env.parameters import Parameters


@WEIGHTING_RULES.register("filter")
class Filter(Parameters):
    """The gain of the chosen estimator itself.

    In the waypoints task: the whole correction, g = 1. In the foraging task: the rule of social
    odometry, covariance intersection or the Kalman filter, depending on the estimator.

    Source: BOIDS, Section II.1.
    """

    tasks: ClassVar[tuple[str, ...]] = ("foraging", "waypoints", "epuck")

    def layer(self, scenario: object) -> WeightingLayer | None:
        """Return None, which selects the rule of the estimator."""
        return None
