"""Localisation: the common parameters of all estimators of a pose.

Smith et al. 2021 (BOIDS), Section 2. `setting` chooses between two readings of the paper:

- `authors`: the code behind its figures. Process noise and measurement noise are diagonals of
  standard deviations; home resets the estimate; the filter corrects one robot of two, behind
  gates; flocks align on positions.
- `corrected`: textbook noise, propagated by the Jacobians; home is a private measurement update;
  both robots are corrected; flocks align on velocities; the covariance stimulus has a scale that
  fits such covariances.

Not in the paper, and chosen here: the corrected filters treat a device's constant error as a part
of its noise (the variances add up), as they have no measurement of it.
"""

from collections.abc import Mapping
from typing import ClassVar, Literal

from pydantic import Field

from baselines.estimators.boids_inputs import describe
from baselines.estimators.pose_prediction import PoseMind
from swarm_forage_env.compiler import kernel
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.interface import EstimatorLayer, Kernel, WeightingLayer
from swarm_forage_env.parameters import Parameters
from swarm_forage_env.record import Numbers, Record
from swarm_forage_env.waypoints.control import observe_world
from swarm_forage_env.waypoints.records import Exchange
from swarm_forage_env.waypoints.scenario import WaypointsScenario

COVARIANCE_NORM_MAX = {"authors": 5.0, "corrected": 0.05}
"""Highest covariance norm allowed: 5 (published), or a hundredth for textbook noise (chosen)."""

OFFSET_MAX = 1.0  # highest distance allowed between the estimate and dead reckoning [m] (published)


@kernel
def whole_correction(exchange: Exchange, which: int, numbers: Numbers) -> float:
    """The gain g = 1: every correction is made as the filter computes it.

    Source: BOIDS, Section 2.
    """
    return 1.0


def waypoints_kernels(update_belief: Kernel, merge: Kernel) -> Mapping[str, Kernel]:
    """The functions that the templates of a tick name, where robots visit waypoints."""
    return {"update_belief": update_belief, "describe": describe, "merge": merge}


class Localisation(Parameters):
    """Parameters of an estimator of a pose; a subclass is an estimator.

    Among e-pucks: Smith et al. 2021 (BOIDS), Section 2, over Gutierrez et al. 2009 (TR), Section 5.

    Not in the papers, and chosen here:
    - an e-puck has neither compass nor map: what it estimates are the places of nest and prey in a
      frame of its own, each with an error ellipse, and the area under it is its landmark;
    - neighbours exchange and merge as in social odometry, one partner at a time;
    - dead reckoning tells nobody anything;
    - covariance intersection merges two ellipses with the weight of the fast form for circles,
      p_i^2 / (p_i^2 + p_j^2);
    - the decentralised EKF keeps the cross-covariance of its own estimate and each partner's since
      their last exchange, in its own frame, and takes it into the gain. An exchange may end for one
      robot and break off for the other, so that each corrects itself alone, and a partner's own
      corrections in between are not known.
    """

    tasks: ClassVar[tuple[str, ...]] = ("foraging", "waypoints")
    mind: ClassVar[type[Record]] = PoseMind
    kernels: ClassVar[Mapping[str, Kernel]]
    setting: Literal["authors", "corrected"] = Field(
        "corrected",
        description="What made the paper's figures (waypoints only), or textbook filters (chosen)",
    )

    def layer(self, scenario: Scenario | WaypointsScenario) -> EstimatorLayer:
        """The records and functions of the estimator, with its numbers in a scenario.

        ConfigError for the authors' setting where robots forage.
        """
        if isinstance(scenario, WaypointsScenario):
            return self.waypoints_layer(scenario)
        if self.setting != "corrected":
            raise ConfigError(
                f"setting='{self.setting}': is of robots that visit waypoints, not of"
                f" {scenario.name}; leave it out"
            )
        return self.foraging_layer(scenario)

    def waypoints_layer(self, scenario: WaypointsScenario) -> EstimatorLayer:
        """The layer where robots visit waypoints."""
        numbers, own = self.numbers(scenario), WeightingLayer(whole_correction)
        return EstimatorLayer(self.mind, numbers, self.kernels, observe_world, own_weighting=own)

    def foraging_layer(self, scenario: Scenario) -> EstimatorLayer:
        """The layer where robots forage."""
        raise NotImplementedError

    def numbers(self, scenario: WaypointsScenario) -> dict[str, float]:
        """The scenario's noise and limits as kernels read them."""
        sensors = scenario.sensors
        return {
            "authors": self.setting == "authors",
            "dt": scenario.tick,
            "speed_noise": sensors.speed_noise,
            "turn_noise": sensors.turn_noise,
            "var_speed": sensors.speed_noise**2 + sensors.speed_bias**2,
            "var_turn": sensors.turn_noise**2 + sensors.turn_bias**2,
            "range_noise": sensors.range_noise,
            "bearing_noise": sensors.bearing_noise,
            "home_variance": sensors.home_noise**2,
            "reach": sensors.reach,
            "max_speed": scenario.robot.max_speed,
            "tolerance": scenario.task.tolerance,
            "covariance_norm_max": COVARIANCE_NORM_MAX[self.setting],
            "offset_max": OFFSET_MAX,
        }
