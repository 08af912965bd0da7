"""Dead reckoning: an estimate of the own pose without any neighbour, between visits at home.

Smith et al. 2021 (BOIDS), Section 2.1.
"""

from typing import ClassVar

from baselines.estimators import foraging_variants
from baselines.estimators.base import ESTIMATORS
from baselines.estimators.boids_inputs import describe
from baselines.estimators.localisation import OWN_WEIGHTING, Localisation
from baselines.estimators.pose_belief import PoseMind
from baselines.estimators.pose_prediction import take_in_alone
from swarm_forage_env.arrays import Array
from swarm_forage_env.compiler import kernel
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.interface import EstimatorLayer, Kernel
from swarm_forage_env.record import Numbers
from swarm_forage_env.waypoints.control import observe_world
from swarm_forage_env.waypoints.scenario import WaypointsScenario


@kernel
def correct_nothing(crowd: Array, shared: Array, sightings: Array, numbers: Numbers) -> None:
    """No neighbour corrects an estimate that is reckoned alone."""


KERNELS: dict[str, Kernel] = {
    "take_in": take_in_alone,
    "describe": describe,
    "merge": correct_nothing,
}


@ESTIMATORS.register("dead_reckoning")
class DeadReckoning(Localisation):
    """Dead reckoning: robots tell each other nothing."""

    speaks: ClassVar[bool] = False

    def waypoints_layer(self, scenario: WaypointsScenario) -> EstimatorLayer:
        """Poses that wheels and gyro reckon, corrected at home alone."""
        numbers = self.numbers(scenario)
        return EstimatorLayer(
            PoseMind, numbers, KERNELS, observe_world, own_weighting=OWN_WEIGHTING
        )

    def foraging_layer(self, scenario: Scenario) -> EstimatorLayer:
        """Social odometry of robots that do not speak."""
        return foraging_variants.dead_reckoning(scenario)
