"""Dead reckoning: an estimate of the robot's pose from odometry and visits at home alone.

Smith et al. 2021 (BOIDS), Section II.1.
"""

from typing import ClassVar

from baselines.estimators.base import ESTIMATORS
from baselines.estimators.localisation import Localisation, waypoints_kernels
from baselines.estimators.pose_prediction import update_belief_alone
from baselines.estimators.sikf import CovarianceFilterParameters
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.interface import EstimatorLayer
from swarm_forage_env.ticks import nothing


@ESTIMATORS.register("dead_reckoning")
class DeadReckoning(Localisation):
    """Dead reckoning: robots do not communicate."""

    speaks: ClassVar[bool] = False
    kernels = waypoints_kernels(update_belief_alone, nothing)

    def foraging_layer(self, scenario: Scenario) -> EstimatorLayer:
        """Return the layer of social odometry with covariances, without communication."""
        return CovarianceFilterParameters(speaks=False).layer(scenario)
