"""The named baselines, one line each. A name takes parameters: `ssgiff:beta=0.01`."""

from baselines.controller import Recipe
from baselines.estimators.social_odometry import SocialOdometryParameters
from baselines.motion.subsumption import SubsumptionParameters
from baselines.weighting.sgiff import SGIFF
from baselines.weighting.sgikf import SGIKF
from swarm_forage_env.registry import CONTROLLERS

ALONE = SocialOdometryParameters(speaks=False)
SINGLE = SocialOdometryParameters(double=False)
DOUBLE = SocialOdometryParameters(double=True)
SUBSUMPTION = SubsumptionParameters()

RECIPES = (
    Recipe("nc", ALONE, SGIKF(), SUBSUMPTION),
    Recipe("ssgikf", SINGLE, SGIKF(), SUBSUMPTION),
    Recipe("dsgikf", DOUBLE, SGIKF(), SUBSUMPTION),
    Recipe("ssgiff", SINGLE, SGIFF(), SUBSUMPTION),
    Recipe("dsgiff", DOUBLE, SGIFF(), SUBSUMPTION),
)
"""The strategies of TR 6.1: no communication, and the single and double filters."""

for recipe in RECIPES:
    CONTROLLERS.register(recipe.name)(recipe)
