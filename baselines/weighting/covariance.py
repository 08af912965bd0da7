"""Covariance knowledge: the heard matrix is taken at its word."""

from typing import ClassVar

import numpy as np

from baselines.weighting.base import WEIGHTING_RULES
from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.interface import Encounter
from swarm_forage_env.scenario import Part


@WEIGHTING_RULES.register("covariance")
class Covariance(Part):
    """Own and heard covariance count alike; which estimate counts more, the matrices say.

        g = 1 / 2

    The estimator `covariance` makes the gain matrix K_i = g P_i (g P_i + (1 - g) P_j)^-1 of it:
    for g = 1/2 the paper's, for g = 0 nothing is taken over, for g = 1 all.

    Source: TR, Eq. 22; ANTS, Section 5 (covariance knowledge).
    """

    heard_p_share: ClassVar[float] = 0.0

    def __call__(self, encounter: Encounter) -> Float32[Array, "rows areas"]:
        """g for each row and area."""
        return np.full_like(encounter.own_p, 0.5)
