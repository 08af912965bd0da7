"""Covariance knowledge: social odometry that exchanges and merges whole error ellipses.

Gutierrez et al. 2008 (ANTS), Section 5; Gutierrez et al. 2009 (TR), Eqs. 9-11 and 22-24.

Not in the paper, and chosen here:
- matrices are those of the position, 2 x 2. An exchange corrects the position only: the variance
  of the heading is unchanged and still feeds the growth of the position's covariance;
- the matrix is sent as an error ellipse, turned from frame to frame by the measured bearings
  as the area's direction is, and averaged over the exchange like the location;
- a robot that copies an estimate copies its matrix, and its heading counts as exact from there on;
- where two matrices have no joint inverse their norms are compared;
- the error of the measured beam enters nowhere, as in the paper;
- the error constants match the encoders of the scenario at the cruise speed;
- one area is exchanged, as in SSGIKF, unless `double`;
- all that `social_odometry` chose.
"""

from baselines.estimators.base import ESTIMATORS
from baselines.estimators.covariance_exchange import EllipseMind, compose, listen, merge
from baselines.estimators.falsified_messages import falsify_ellipse, repeat_ellipse
from baselines.estimators.path_covariance import take_in
from baselines.estimators.sikf import CovarianceFilterParameters
from baselines.estimators.social_odometry import KERNELS as SOCIAL_KERNELS
from baselines.weighting.covariance import Covariance
from swarm_forage_env.foraging.control import observe_world
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.interface import EstimatorLayer, Kernel

KERNELS: dict[str, Kernel] = {
    **SOCIAL_KERNELS,
    "compose": compose,
    "repeat": repeat_ellipse,
    "falsify": falsify_ellipse,
    "take_in": take_in,
    "listen": listen,
    "merge": merge,
}
"""The functions of the filter that the templates of a tick name."""


@ESTIMATORS.register("covariance")
class CovarianceParameters(CovarianceFilterParameters):
    """Social odometry whose robots exchange error ellipses.

    Its numbers are those of social odometry; the covariance follows from the scenario.
    """

    def layer(self, scenario: Scenario) -> EstimatorLayer:
        """The records and functions of the estimator, with its numbers in a scenario."""
        own = Covariance().layer(scenario)
        numbers = {**self.numbers(scenario), "intersects": 0.0}
        return EstimatorLayer(EllipseMind, numbers, KERNELS, observe_world, own_weighting=own)
