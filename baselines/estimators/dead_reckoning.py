"""Dead reckoning: an estimate of the own pose without any neighbour, between visits at home.

Smith et al. 2021 (BOIDS), Section 2.1.
"""

from collections.abc import Mapping
from typing import ClassVar

from baselines.estimators.base import ESTIMATORS
from baselines.estimators.boids_inputs import describe
from baselines.estimators.localisation import Localisation
from baselines.estimators.pose_prediction import take_in_alone
from baselines.estimators.sikf import CovarianceFilterParameters
from swarm_forage_env.arrays import Array
from swarm_forage_env.compiler import kernel
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.interface import EstimatorLayer, Kernel
from swarm_forage_env.record import Numbers


@kernel
def correct_nothing(crowd: Array, shared: Array, sightings: Array, numbers: Numbers) -> None:
    """No neighbour corrects an estimate that is reckoned alone."""


@ESTIMATORS.register("dead_reckoning")
class DeadReckoning(Localisation):
    """Dead reckoning: robots tell each other nothing."""

    speaks: ClassVar[bool] = False
    kernels: ClassVar[Mapping[str, Kernel]] = {
        "update_belief": take_in_alone, "describe": describe, "merge": correct_nothing,
    }  # fmt: skip

    def foraging_layer(self, scenario: Scenario) -> EstimatorLayer:
        """Social odometry of robots that do not speak: places with covariances."""
        return CovarianceFilterParameters(speaks=False).layer(scenario)
