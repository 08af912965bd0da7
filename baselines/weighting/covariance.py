"""Covariance knowledge: own and heard matrices count alike."""

from baselines.weighting.base import WEIGHTING_RULES
from swarm_forage_env.compiler import kernel
from swarm_forage_env.foraging.records import Exchange
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.interface import WeightingLayer
from swarm_forage_env.parameters import Parameters
from swarm_forage_env.record import Numbers


@kernel
def gain(exchange: Exchange, area: int, numbers: Numbers) -> float:
    """The weight g = 1 / 2: both covariances count alike."""
    return 0.5


@WEIGHTING_RULES.register("covariance")
class Covariance(Parameters):
    """Own and heard covariance count alike; which estimate counts more, the matrices say.

        g = 1 / 2

    The estimator `covariance` makes the gain matrix K_i = g P_i (g P_i + (1 - g) P_j)^-1 of it:
    for g = 1/2 the paper's, for g = 0 nothing is taken over, for g = 1 all.

    Source: TR, Eq. 22; ANTS, Section 5 (covariance knowledge).
    """

    def layer(self, scenario: Scenario) -> WeightingLayer:
        """The function of the rule."""
        return WeightingLayer(gain)
