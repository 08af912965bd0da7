"""A package of somebody else's: two weighting rules, a controller and an environment id of its own.

Its entry point, in the group `swarm_forage_env.controllers`, names this module.
"""

from typing import ClassVar

import gymnasium
import numpy as np
from pydantic import Field

from baselines.controller import LayeredController
from baselines.estimators.social_odometry import SocialOdometryParameters
from baselines.motion.subsumption import SubsumptionParameters
from baselines.weighting import sgikf
from baselines.weighting.base import WEIGHTING_RULES
from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.compiler import kernel
from swarm_forage_env.foraging.records import Exchange
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.interface import WeightingLayer
from swarm_forage_env.parameters import Parameters, Share
from swarm_forage_env.record import Numbers, Rows
from swarm_forage_env.registry import CONTROLLERS


@kernel
def gain(exchange: Exchange, area: int, numbers: Numbers) -> float:
    """The share of the gain of SGIKF that is trusted."""
    return numbers.trust * sgikf.gain(exchange, area, numbers)


@WEIGHTING_RULES.register("cautious")
class Cautious(Parameters):
    """A share of the gain of SGIKF: whoever hears something believes it in part only."""

    trust: Share = Field(0.5, description="Share of the gain")

    def layer(self, scenario: Scenario) -> WeightingLayer:
        """The function of the rule, with its share."""
        return WeightingLayer(gain, {"trust": self.trust})


@WEIGHTING_RULES.register("cautious_arrays")
class CautiousArrays(Parameters):
    """The same rule in NumPy: called with the exchanges of all robots, and compiled by nobody."""

    heard_p_share: ClassVar[float] = 0.0

    trust: Share = Field(0.5, description="Share of the gain")

    def __call__(self, exchange: Rows) -> Float32[Array, "rows areas"]:
        """The weight of each row and area."""
        total = exchange.own_p + exchange.heard_p
        half = np.full_like(total, 0.5)
        g = np.divide(exchange.own_p, total, out=half, where=total > 0.0)
        return g * g.dtype.type(self.trust)


CAUTIOUS = LayeredController(
    "cautious", SocialOdometryParameters(), Cautious(), SubsumptionParameters()
)
CONTROLLERS.register(CAUTIOUS.name)(CAUTIOUS)

gymnasium.register(
    "CautiousSwarm/ES1-v0",
    "swarm_forage_env.envs.gymnasium_env:LearnerEnv",
    vector_entry_point="swarm_forage_env.envs.gymnasium_vector:LearnerVectorEnv",
    kwargs={"scenario": "es1", "controller": "cautious", "reward": "team", "n_robots": 5},
)
