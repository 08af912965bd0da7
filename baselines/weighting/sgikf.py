"""The Social Generalised Induced Kalman Filter."""

from typing import ClassVar

import numpy as np

from baselines.weighting.base import WEIGHTING_RULES
from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.interface import Encounter
from swarm_forage_env.scenario import Part


@WEIGHTING_RULES.register("sgikf")
class SGIKF(Part):
    """The gain of an induced Kalman filter, with path lengths for covariances.

        g_i = p_i / (p_i + p_j)
        p_i = (1 - g_i) p_i

    p_i and p_j are the own and the heard path since the area [m]. Not in the paper: two
    robots that both stand on the area (p_i = p_j = 0) meet half-way.

    Source: TR, Eq. 33 and 35.
    """

    heard_p_share: ClassVar[float] = 0.0

    def __call__(self, encounter: Encounter) -> Float32[Array, "rows areas"]:
        """g for each row and area."""
        own, total = encounter.own_p, encounter.own_p + encounter.heard_p
        g = np.full_like(own, 0.5)
        np.divide(own, total, out=g, where=total > 0.0)
        return g
