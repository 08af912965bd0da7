"""Covariance knowledge: social odometry that exchanges and merges whole error ellipses.

Gutierrez et al. 2008 (ANTS), Section 5; Gutierrez et al. 2009 (TR), Eqs. 9-11 and 22-24.

Not in the paper, and chosen here:
- matrices are those of the position, 2 x 2; the pose's heading stays as uncertain as it was,
  for no exchange corrects it, and keeps its part in the growth of the position's matrix;
- the matrix is sent as an error ellipse, turned from frame to frame by the measured bearings
  as the area's direction is, and averaged over the exchange like the location;
- whoever copies an estimate copies its matrix, and its heading counts as exact from there on;
- where two matrices have no joint inverse their norms are compared;
- the error of the measured beam enters nowhere, as in the paper;
- the error constants match the encoders of the scenario at the cruise speed;
- one area is exchanged, as in SSGIKF, unless `double`;
- all that `social_odometry` chose.
"""

from typing import Any

import numpy as np

from baselines.estimators.base import ESTIMATORS
from baselines.estimators.ellipses import merge_ellipses, note_ellipses, tell_ellipses
from baselines.estimators.sikf import Uncertain, UncertainParameters
from baselines.estimators.social_odometry import SocialOdometryParameters
from baselines.weighting.covariance import Covariance
from swarm_forage_env.arrays import Array, Bool, Float32, Float64
from swarm_forage_env.interface import Heard
from swarm_forage_env.scenario import Scenario


@ESTIMATORS.register("covariance")
class CovarianceParameters(UncertainParameters):
    """What social odometry leaves open; the covariance follows from the scenario."""

    def start(self, scenario: Scenario, n_worlds: int) -> "CovarianceKnowledge":
        """The running estimator of a block of worlds."""
        return CovarianceKnowledge(self, scenario, n_worlds)


class CovarianceKnowledge(Uncertain):
    """The estimates and covariances of all robots of a block of worlds."""

    own_rule: Any = Covariance()
    """The weighting that goes with it."""

    intersects = False
    """Takes the errors of two robots for correlated by an unknown amount."""

    def __init__(
        self, parameters: SocialOdometryParameters, scenario: Scenario, n_worlds: int
    ) -> None:
        """Robots that know nothing yet."""
        super().__init__(parameters, scenario, n_worlds)
        rows = len(self.beliefs.pose)
        self.heard_cov: Float64[Array, "rows areas 3"] = np.zeros((rows, 2, 3))

    def merge(self, g: Float32[Array, "rows areas"], heard_p_share: float) -> None:
        """Blend what the conversations that just ended brought, with the gain matrix for g."""
        b = self.beliefs
        merge_ellipses(
            self.encounter.valid, g, self.parameters.double, self.intersects, b.goal,
            b.heard_sum, b.heard_weight, self.heard_cov, b.location, b.p, b.known, self.moments,
        )  # fmt: skip

    def say(
        self,
    ) -> tuple[Float32[Array, "rows words"], Bool[Array, " rows"], Bool[Array, " rows"]]:
        """The words to broadcast, who broadcasts, and who just got lost."""
        words, speaking, lost = super().say()
        tell_ellipses(self.moments, self.beliefs.pose, words)
        return words, speaking, lost

    def reset(self, world: int, seed: int) -> None:
        """Forget everything about one world."""
        super().reset(world, seed)
        self.heard_cov[world * self._n_robots : (world + 1) * self._n_robots] = 0.0

    def _talk(self, heard: Heard) -> Bool[Array, " rows"]:
        """Listen to the partners, also to their ellipses."""
        b = self.beliefs
        before = b.partner.copy()
        ended = super()._talk(heard)
        note_ellipses(
            heard.valid, heard.sender, heard.words, heard.beam, heard.frames,
            before, b.partner, b.pose, self.heard_cov,
        )  # fmt: skip
        return ended
