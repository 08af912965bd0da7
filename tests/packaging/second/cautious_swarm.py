"""A package of somebody else's: a weighting rule, a controller and an environment id of its own.

Its entry point, in the group `swarm_forage_env.controllers`, names this module.
"""

from typing import ClassVar

import gymnasium
from pydantic import Field

from baselines.controller import Recipe
from baselines.estimators.social_odometry import SocialOdometryParameters
from baselines.motion.subsumption import SubsumptionParameters
from baselines.weighting.base import WEIGHTING_RULES
from baselines.weighting.sgikf import SGIKF
from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.foraging.scenario import Part, Share
from swarm_forage_env.interface import Encounter
from swarm_forage_env.registry import CONTROLLERS


@WEIGHTING_RULES.register("cautious")
class Cautious(Part):
    """A share of the gain of SGIKF: whoever hears something believes it in part only."""

    heard_p_share: ClassVar[float] = 0.0

    trust: Share = Field(0.5, description="Share of the gain")

    def __call__(self, encounter: Encounter) -> Float32[Array, "rows areas"]:
        """g for each row and area."""
        return SGIKF()(encounter) * encounter.own_p.dtype.type(self.trust)


RECIPE = Recipe("cautious", SocialOdometryParameters(), Cautious(), SubsumptionParameters())
CONTROLLERS.register(RECIPE.name)(RECIPE)

gymnasium.register(
    "CautiousSwarm/ES1-v0",
    "swarm_forage_env.envs.single:LearnerEnv",
    vector_entry_point="swarm_forage_env.envs.vector:LearnerVectorEnv",
    kwargs={"scenario": "es1", "controller": "cautious", "reward": "team", "n_robots": 5},
)
