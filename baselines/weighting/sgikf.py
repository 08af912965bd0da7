"""The Social Generalised Induced Kalman Filter."""

from baselines.weighting.base import WEIGHTING_RULES
from swarm_forage_env.compiler import kernel
from swarm_forage_env.foraging.records import Exchange
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.interface import WeightingLayer
from swarm_forage_env.parameters import Parameters
from swarm_forage_env.record import Numbers


@kernel
def gain(exchange: Exchange, area: int, numbers: Numbers) -> float:
    """Return the gain g = p_i / (p_i + p_j) of an area; 1/2 if both are 0. Source: TR, Eq. 33."""
    own, total = exchange.own_p[area], exchange.own_p[area] + exchange.heard_p[area]
    return float(own / total) if total > 0.0 else 0.5


@WEIGHTING_RULES.register("sgikf")
class SGIKF(Parameters):
    """The gain of an induced Kalman filter, with path lengths for covariances.

        g_i = p_i / (p_i + p_j)
        p_i = (1 - g_i) p_i

    p_i and p_j are the own and the heard path since the area [m]. Not in the paper: two
    robots that both stand on the area (p_i = p_j = 0) meet half-way.

    Source: TR, Eq. 33 and 35.
    """

    def layer(self, scenario: Scenario) -> WeightingLayer:
        """Return the compiled rule."""
        return WeightingLayer(gain)
