"""The named baselines, one line each. A name takes parameters: `ssgiff:beta=0.01`."""

from baselines.controller import Recipe
from baselines.estimators.covariance import CovarianceParameters
from baselines.estimators.localisation import LocalisationParameters
from baselines.estimators.sikf import SIKFParameters
from baselines.estimators.social_odometry import SocialOdometryParameters
from baselines.motion.boids import BoidsParameters
from baselines.motion.subsumption import SubsumptionParameters
from baselines.weighting.covariance import Covariance
from baselines.weighting.full import Full
from baselines.weighting.sgiff import SGIFF
from baselines.weighting.sgikf import SGIKF
from baselines.weighting.sikf import SIKF
from swarm_forage_env.registry import CONTROLLERS

ALONE = SocialOdometryParameters(speaks=False)
SINGLE = SocialOdometryParameters(double=False)
DOUBLE = SocialOdometryParameters(double=True)
WARY = SocialOdometryParameters(double=True, message_path=4.0, tells_within=20.0)
BRISK = WARY.model_copy(update={"pause": 4.0, "listens_above": 5.0})
SUBSUMPTION = SubsumptionParameters()
LOCALISATION = LocalisationParameters()

RECIPES = (
    Recipe("nc", ALONE, SGIKF(), SUBSUMPTION),
    Recipe("ssgikf", SINGLE, SGIKF(), SUBSUMPTION),
    Recipe("dsgikf", DOUBLE, SGIKF(), SUBSUMPTION),
    Recipe("ssgiff", SINGLE, SGIFF(), SUBSUMPTION),
    Recipe("dsgiff", DOUBLE, SGIFF(), SUBSUMPTION),
    Recipe("dsgiff-wary", WARY, SGIFF(), SUBSUMPTION),
    Recipe("dsgiff-brisk", BRISK, SGIFF(), SUBSUMPTION),
    Recipe("sikf", SIKFParameters(**SINGLE.model_dump()), SIKF(), SUBSUMPTION),
    Recipe("covariance", CovarianceParameters(**SINGLE.model_dump()), Covariance(), SUBSUMPTION),
    Recipe("subsumption", LOCALISATION, Full(), SUBSUMPTION),
    Recipe("boids-goal", LOCALISATION, Full(), BoidsParameters(gains="goal")),
    Recipe("boids-static", LOCALISATION, Full(), BoidsParameters(gains="static")),
    Recipe("boids-adaptive", LOCALISATION, Full(), BoidsParameters(gains="adaptive")),
)
"""The strategies of TR 6.1: no communication, and the single and double filters; the double one
among robots that are wary of hearsay, and among such that talk more often unless they are sure,
neither of which is in the papers; then the filters of covariances that they simplify (TR 4.2,
ANTS 5); then the rules of BOIDS 5, and subsumption over its filters, where robots forage."""

for recipe in RECIPES:
    CONTROLLERS.register(recipe.name)(recipe)
