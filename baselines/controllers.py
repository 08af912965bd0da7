"""The named baselines, one line each. Parameters follow the name: `ssgiff:beta=0.01`.

The names of three layers also make a controller: `social_odometry+sgiff+subsumption`.
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

TABLE = (
    ("nc", "robots do not communicate", ALONE, SGIKF(), SUBSUMPTION),
    ("ssgikf", "robots correct the area they head for, with the gain of a Kalman filter",
     SINGLE, SGIKF(), SUBSUMPTION),
    ("dsgikf", "ssgikf whose robots exchange both areas",
     DOUBLE, SGIKF(), SUBSUMPTION),
    ("ssgiff", "ssgikf weighted by a Fermi function of steepness beta",
     SINGLE, SGIFF(), SUBSUMPTION),
    ("dsgiff", "ssgiff whose robots exchange both areas",
     DOUBLE, SGIFF(), SUBSUMPTION),
    ("dsgiff-penalised", "dsgiff that adds a path to each received estimate",
     PENALISED, SGIFF(), SUBSUMPTION),
    ("dsgiff-frequent", "dsgiff-penalised whose uncertain robots exchange more often",
     FREQUENT, SGIFF(), SUBSUMPTION),
    ("ssgikf-sceptical", "ssgikf that checks estimates by a witness and a gate, against liars",
     SCEPTICAL, ValidationGate(), SUBSUMPTION),
    ("sikf", "robots exchange the norm of a covariance",
     SIKFParameters(**SINGLE_FIELDS), SIKF(), SUBSUMPTION),
    ("covariance", "robots exchange full covariance matrices",
     CovarianceParameters(**SINGLE_FIELDS), Covariance(), SUBSUMPTION),
    ("subsumption", "robots go straight to the goal, localised by the filter of the boids",
     EKF, Filter(), SUBSUMPTION),
    ("boids-goal", "boids with the rule of the goal alone",
     EKF, Filter(), BoidsParameters(gains="goal")),
    ("boids-static", "boids with fixed gains", EKF, Filter(), BoidsParameters(gains="static")),
    ("boids-adaptive", "boids whose gains follow the uncertainty",
     EKF, Filter(), BoidsParameters(gains="adaptive")),
    ("gather", "robots stop on black floor, and leave it more rarely among neighbours",
     NoEstimator(), Filter(), Gather()),
)  # fmt: skip
"""Name, description and layers of each controller, in this order: the strategies of TR 6.1 (no
communication, single and double filters); double filters with a penalty on hearsay, and with more
frequent exchanges of unsure robots; the single filter with a second witness and a gate against
liars; the covariance filters that these simplify (TR 4.2, ANTS 5); subsumption over the filter of
BOIDS, and the rules of BOIDS IV; gathering, for the aggregation task."""

NAMED = tuple(LayeredController(name, *layers) for name, _, *layers in TABLE)

for controller, (name, about, *_) in zip(NAMED, TABLE, strict=True):
    CONTROLLERS.register(name, about)(controller)

OLD_NAMES = {"dsgiff-wary": "dsgiff-penalised", "dsgiff-brisk": "dsgiff-frequent"}
"""Old name -> new name; old names still work for one release."""

for old, new in OLD_NAMES.items():
    CONTROLLERS.alias(old, new)


def compose(name: str, layers: Sequence[str]) -> LayeredController:
    """Return the controller of an estimator, a weighting and a motion with default parameters.

    ConfigError unless there are three names, UnknownNameError for an unknown name.
    """
    if len(layers) != 3:
        raise ConfigError(
            f"controller='{name}': must be estimator+weighting+motion, as in"
            " social_odometry+sgiff+subsumption"
        )
    estimator, weighting, motion = layers
    parts = ESTIMATORS[estimator](), WEIGHTING_RULES[weighting](), MOTIONS[motion]()
    return LayeredController("+".join(layers), *parts)


CONTROLLERS.compose_by(compose, (ESTIMATORS, WEIGHTING_RULES, MOTIONS))
