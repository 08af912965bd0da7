"""The Social Generalised Induced Fermi Filter."""

import numpy as np
from pydantic import Field

from baselines.weighting.base import WEIGHTING_RULES
from swarm_forage_env.compiler import kernel
from swarm_forage_env.equations.elementary import tanh
from swarm_forage_env.foraging.records import Exchange
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.interface import WeightingLayer
from swarm_forage_env.parameters import NotNegative, Parameters
from swarm_forage_env.record import Numbers

CENTIMETRES = 100.0


@kernel
def gain(exchange: Exchange, area: int, numbers: Numbers) -> float:
    """Return the Fermi function of an area, written as a tanh, which cannot overflow.

    Source: TR, Eq. 37.
    """
    steepness = 0.5 * numbers.beta * CENTIMETRES
    ahead = np.float64(exchange.own_p[area]) - np.float64(exchange.heard_p[area])
    return 0.5 + 0.5 * tanh(steepness * ahead)


@WEIGHTING_RULES.register("sgiff")
class SGIFF(Parameters):
    """Imitation by the Fermi function of the difference in confidence.

        g_i = 1 / (1 + exp(-beta (p_i - p_j)))
        p_i = (1 - g_i) p_i + g_i p_j

    p_i and p_j are the own and the heard path since the area. Not in the paper: their unit;
    here beta is per centimetre (with metres no beta of the papers would tell two robots
    apart; per millimetre its best decade here would be a tenth of the published one).

    Source: TR, Eq. 37 and 39; ANTS, Eq. 3.
    """

    beta: NotNegative = Field(
        0.01, le=1e6, description="Steepness [1/cm]. Best in ES1 and ES2: TR 6.1.2 (published)"
    )

    def layer(self, scenario: Scenario) -> WeightingLayer:
        """Return the compiled rule with its steepness."""
        return WeightingLayer(gain, {"beta": self.beta}, heard_p_share=1.0)
