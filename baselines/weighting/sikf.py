"""The Social Induced Kalman Filter's gain."""

from typing import ClassVar

import numpy as np

from baselines.weighting.base import WEIGHTING_RULES
from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.interface import Encounter
from swarm_forage_env.scenario import Part


@WEIGHTING_RULES.register("sikf")
class SIKF(Part):
    """The gain of a Kalman filter, with norms of covariances for covariances.

        g_i = |P_i| / (|P_i| + |P_j|)

    |P| = p^2 [m^2], where p is the standard deviation that the estimator `sikf` shows [m].
    Not in the paper: two robots that both stand on the area (p_i = p_j = 0) meet half-way.

    Source: TR, Eq. 33.
    """

    heard_p_share: ClassVar[float] = 0.0

    def __call__(self, encounter: Encounter) -> Float32[Array, "rows areas"]:
        """g for each row and area."""
        own = encounter.own_p.astype(np.float64) ** 2
        total = own + encounter.heard_p.astype(np.float64) ** 2
        g = np.full_like(own, 0.5)
        np.divide(own, total, out=g, where=total > 0.0)
        return g.astype(np.float32)
