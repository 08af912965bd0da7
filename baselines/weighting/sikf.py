"""The gain of the Social Induced Kalman Filter."""

import numpy as np

from baselines.weighting.base import WEIGHTING_RULES
from swarm_forage_env.compiler import kernel
from swarm_forage_env.foraging.records import Exchange
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.interface import WeightingLayer
from swarm_forage_env.parameters import Parameters
from swarm_forage_env.record import Numbers


@kernel
def gain(exchange: Exchange, area: int, numbers: Numbers) -> float:
    """The gain g = |P_i| / (|P_i| + |P_j|) of an area; 1/2 where both are 0. Source: TR, Eq. 33."""
    own, heard = np.float64(exchange.own_p[area]), np.float64(exchange.heard_p[area])
    total = own * own + heard * heard
    return own * own / total if total > 0.0 else 0.5


@WEIGHTING_RULES.register("sikf")
class SIKF(Parameters):
    """The gain of a Kalman filter, with norms in place of covariance matrices.

        g_i = |P_i| / (|P_i| + |P_j|)

    |P| = p^2 [m^2], where p is the standard deviation computed by the estimator `sikf` [m].
    Not in the paper: two robots that both stand on the area (p_i = p_j = 0) meet half-way.

    Source: TR, Eq. 33.
    """

    def layer(self, scenario: Scenario) -> WeightingLayer:
        """Return the compiled rule."""
        return WeightingLayer(gain)
