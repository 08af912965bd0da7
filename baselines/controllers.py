"""The named baselines, one line each. A name takes parameters: `ssgiff:beta=0.01`.

Layers by their own names make a controller too: `social_odometry+sgiff+subsumption`.
"""

from collections.abc import Sequence

from baselines.controller import LayeredController
from baselines.estimators import ESTIMATORS
from baselines.estimators.covariance import CovarianceParameters
from baselines.estimators.decentralised_ekf import DecentralisedEKF
from baselines.estimators.no_estimator import NoEstimator
from baselines.estimators.sceptical_odometry import ScepticalOdometryParameters
from baselines.estimators.sikf import SIKFParameters
from baselines.estimators.social_odometry import SocialOdometryParameters
from baselines.motion import MOTIONS
from baselines.motion.boids import BoidsParameters
from baselines.motion.gather import Gather
from baselines.motion.subsumption import SubsumptionParameters
from baselines.weighting import WEIGHTING_RULES
from baselines.weighting.covariance import Covariance
from baselines.weighting.filter import Filter
from baselines.weighting.sgiff import SGIFF
from baselines.weighting.sgikf import SGIKF
from baselines.weighting.sikf import SIKF
from baselines.weighting.validation_gate import ValidationGate
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.registry import CONTROLLERS

ALONE = SocialOdometryParameters(speaks=False)
SINGLE = SocialOdometryParameters(double=False)
DOUBLE = SocialOdometryParameters(double=True)
PENALISED = SocialOdometryParameters(double=True, message_path=4.0, tells_within=20.0)
FREQUENT = PENALISED.model_copy(update={"pause": 4.0, "listens_above": 5.0})
SINGLE_FIELDS = SINGLE.model_dump()
SCEPTICAL = ScepticalOdometryParameters(pause=5.0, refractory=10.0)
SUBSUMPTION = SubsumptionParameters()
EKF = DecentralisedEKF()

NAMED = (
    LayeredController("nc", ALONE, SGIKF(), SUBSUMPTION),
    LayeredController("ssgikf", SINGLE, SGIKF(), SUBSUMPTION),
    LayeredController("dsgikf", DOUBLE, SGIKF(), SUBSUMPTION),
    LayeredController("ssgiff", SINGLE, SGIFF(), SUBSUMPTION),
    LayeredController("dsgiff", DOUBLE, SGIFF(), SUBSUMPTION),
    LayeredController("dsgiff-penalised", PENALISED, SGIFF(), SUBSUMPTION),
    LayeredController("dsgiff-frequent", FREQUENT, SGIFF(), SUBSUMPTION),
    LayeredController("ssgikf-sceptical", SCEPTICAL, ValidationGate(), SUBSUMPTION),
    LayeredController("sikf", SIKFParameters(**SINGLE_FIELDS), SIKF(), SUBSUMPTION),
    LayeredController(
        "covariance", CovarianceParameters(**SINGLE_FIELDS), Covariance(), SUBSUMPTION
    ),
    LayeredController("subsumption", EKF, Filter(), SUBSUMPTION),
    LayeredController("boids-goal", EKF, Filter(), BoidsParameters(gains="goal")),
    LayeredController("boids-static", EKF, Filter(), BoidsParameters(gains="static")),
    LayeredController("boids-adaptive", EKF, Filter(), BoidsParameters(gains="adaptive")),
    LayeredController("gather", NoEstimator(), Filter(), Gather()),
)
"""The strategies of TR 6.1: no communication, and the single and double filters; the double one
with a penalty on hearsay, and with more frequent exchanges of robots that are unsure; the single
one with a second witness and a gate against liars; then the filters of covariances that they
simplify (TR 4.2, ANTS 5); then the rules of BOIDS 5, and subsumption over its filters, where robots
forage; and gathering, for the task of aggregation."""

ABOUT = {
    "nc": "robots tell each other nothing",
    "ssgikf": "robots hear of the area they go to; weighs as a Kalman filter would",
    "dsgikf": "ssgikf whose robots tell each other of both areas",
    "ssgiff": "ssgikf that weighs by a Fermi function, as sharply as beta says",
    "dsgiff": "ssgiff whose robots tell each other of both areas",
    "dsgiff-penalised": "dsgiff that counts a message as a longer path",
    "dsgiff-frequent": "dsgiff-penalised that exchanges more often while unsure",
    "ssgikf-sceptical": "ssgikf with a second witness and a gate, against liars",
    "sikf": "robots exchange the norm of a covariance",
    "covariance": "robots exchange whole error ellipses",
    "subsumption": "straight to the goal, over the filter of the boids",
    "boids-goal": "boids that follow the rule of the goal alone",
    "boids-static": "boids with fixed gains",
    "boids-adaptive": "boids whose gains follow the uncertainty",
    "gather": "stops on black floor, and leaves it the less the more are near",
}
"""What each controller is, in words."""

for controller in NAMED:
    CONTROLLERS.register(controller.name, ABOUT[controller.name])(controller)

OLD_NAMES = {"dsgiff-wary": "dsgiff-penalised", "dsgiff-brisk": "dsgiff-frequent"}
"""Names of earlier releases, which go on working for one more."""

for old, new in OLD_NAMES.items():
    CONTROLLERS.alias(old, new)


def compose(name: str, layers: Sequence[str]) -> LayeredController:
    """The controller of an estimator, a weighting and a motion, each with its defaults.

    ConfigError if they are not three, UnknownNameError for one that there is not.
    """
    if len(layers) != 3:
        raise ConfigError(
            f"controller='{name}': must be estimator+weighting+motion, as in"
            " social_odometry+sgiff+subsumption"
        )
    estimator, weighting, motion = layers
    parts = ESTIMATORS[estimator](), WEIGHTING_RULES[weighting](), MOTIONS[motion]()
    return LayeredController("+".join(layers), *parts)


CONTROLLERS.compose_by(compose)
