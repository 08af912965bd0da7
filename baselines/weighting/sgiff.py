"""The Social Generalised Induced Fermi Filter."""

from typing import ClassVar

import numpy as np
from pydantic import Field

from baselines.weighting.base import WEIGHTING_RULES
from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.interface import Encounter
from swarm_forage_env.scenario import NotNegative, Part

CENTIMETRES = 100.0


@WEIGHTING_RULES.register("sgiff")
class SGIFF(Part):
    """Imitation by the Fermi function of the difference in confidence.

        g_i = 1 / (1 + exp(-beta (p_i - p_j)))
        p_i = (1 - g_i) p_i + g_i p_j

    p_i and p_j are the own and the heard path since the area. Not in the paper: their unit;
    here beta is per centimetre (with metres no beta of the papers would tell two robots
    apart; per millimetre its best decade here would be a tenth of the published one).

    Source: TR, Eq. 37 and 39; ANTS, Eq. 3.
    """

    heard_p_share: ClassVar[float] = 1.0

    beta: NotNegative = Field(
        0.01, description="Steepness [1/cm]. Best in ES1 and ES2: TR 6.1.2 (published)"
    )

    def __call__(self, encounter: Encounter) -> Float32[Array, "rows areas"]:
        """g for each row and area; written as a tanh, which cannot overflow."""
        steepness = np.float32(0.5 * self.beta * CENTIMETRES)
        difference = encounter.own_p - encounter.heard_p
        return np.asarray(0.5 + 0.5 * np.tanh(steepness * difference))
