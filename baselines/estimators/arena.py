"""The estimators of adaptive boids among e-pucks: what they become where robots forage.

Smith et al. 2021 (BOIDS), Section 2, over Gutierrez et al. 2009 (TR), Section 5.

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

from typing import Any

import numpy as np

from baselines.estimators.correlations import forget_correlations, merge_correlated
from baselines.estimators.covariance import CovarianceKnowledge
from baselines.estimators.sikf import Uncertain
from baselines.estimators.social_odometry import SocialOdometry, SocialOdometryParameters
from baselines.weighting.sikf import SIKF
from swarm_forage_env.arrays import Array, Bool, Float32, Float64, Int32
from swarm_forage_env.interface import Heard, Readings
from swarm_forage_env.scenario import Scenario


class Intersection(CovarianceKnowledge):
    """Places and ellipses, merged by covariance intersection."""

    own_rule: Any = SIKF()
    intersects = True


class Correlated(CovarianceKnowledge):
    """Places and ellipses, merged by a Kalman filter that knows how errors go together."""

    def __init__(
        self, parameters: SocialOdometryParameters, scenario: Scenario, n_worlds: int
    ) -> None:
        """Robots that know nothing yet."""
        super().__init__(parameters, scenario, n_worlds)
        rows = len(self.beliefs.pose)
        shape = (rows, scenario.task.n_robots, 2, 2, 2)
        self.correlations: Float64[Array, "rows robots areas 2 2"] = np.zeros(shape)
        self._last_partner: Int32[Array, " rows"] = np.full(rows, -1, np.int32)

    def merge(self, g: Float32[Array, "rows areas"], heard_p_share: float) -> None:
        """Blend what the conversations that just ended brought."""
        b = self.beliefs
        merge_correlated(
            self.encounter.valid, g, self.parameters.double, self._last_partner, b.goal,
            b.heard_sum, b.heard_weight, self.heard_cov, b.location, b.p, b.known,
            self.moments, self.correlations,
        )  # fmt: skip

    def reset(self, world: int, seed: int) -> None:
        """Forget everything about one world."""
        super().reset(world, seed)
        self.correlations[world * self._n_robots : (world + 1) * self._n_robots] = 0.0

    def _reckon(self, readings: Readings) -> Readings:
        """Move and find areas; an area found anew shares its error with nobody."""
        readings = super()._reckon(readings)
        forget_correlations(self.beliefs.on_area, self.beliefs.known, self.correlations)
        return readings

    def _talk(self, heard: Heard) -> Bool[Array, " rows"]:
        """Listen to the partners, and remember whom."""
        before = self.beliefs.partner.copy()
        ended = super()._talk(heard)
        self._last_partner[:] = np.where(before >= 0, before, self.beliefs.partner)
        return ended


def start_in_arena(kind: str, scenario: Scenario, n_worlds: int) -> SocialOdometry:
    """The running estimator of that name for a block of worlds in which robots forage."""
    if kind == "dead_reckoning":
        return Uncertain(SocialOdometryParameters(speaks=False), scenario, n_worlds)
    made: dict[str, type[SocialOdometry]] = {
        "social_odometry": SocialOdometry,
        "covariance_intersection": Intersection,
        "decentralised_ekf": Correlated,
    }
    return made[kind](SocialOdometryParameters(), scenario, n_worlds)
