"""Weighting for estimators that exchange covariances: both matrices have the same weight."""

from baselines.weighting.base import WEIGHTING_RULES
from swarm_forage_env.compiler import kernel
from swarm_forage_env.foraging.records import Exchange
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.interface import WeightingLayer
from swarm_forage_env.parameters import Parameters
from swarm_forage_env.record import Numbers


@kernel
def gain(exchange: Exchange, area: int, numbers: Numbers) -> float:
    """Return the weight g = 1 / 2: both covariances have the same weight."""
    return 0.5


@WEIGHTING_RULES.register("covariance")
class Covariance(Parameters):
    """Own and heard covariance have equal weight; the matrices determine that of the estimates.

        g = 1 / 2

    The estimator `covariance` computes the gain matrix K_i = g P_i (g P_i + (1 - g) P_j)^-1:
    g = 1/2 gives that of the paper, g = 0 keeps the own estimate, g = 1 copies the received one.

    Source: TR, Eq. 22; ANTS, Section 5 (covariance knowledge).
    """

    def layer(self, scenario: Scenario) -> WeightingLayer:
        """Return the compiled rule."""
        return WeightingLayer(gain)
