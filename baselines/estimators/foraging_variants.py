"""The estimators of adaptive boids among e-pucks: what they become where robots forage.

Smith et al. 2021 (BOIDS), Section 2, over Gutierrez et al. 2009 (TR), Section 5.

Not in the papers, and chosen here:
- an e-puck has neither compass nor map: what it estimates are the places of nest and prey in a
  frame of its own, each with an error ellipse, and the area under it is its landmark;
- neighbours exchange and merge as in social odometry, one partner at a time;
- dead reckoning tells nobody anything;
- covariance intersection merges two ellipses with the weight of the fast form for circles,
  p_i^2 / (p_i^2 + p_j^2);
- the decentralised EKF keeps the cross-covariance of its own estimate and each partner's since
  their last exchange, in its own frame, and takes it into the gain. An exchange may end for one
  robot and break off for the other, so that each corrects itself alone, and a partner's own
  corrections in between are not known.
"""

from dataclasses import replace

from baselines.estimators import cross_covariance
from baselines.estimators.covariance import CovarianceParameters
from baselines.estimators.path_covariance import CovarianceMind, take_in
from baselines.estimators.sikf import CovarianceFilterParameters
from baselines.estimators.social_odometry import KERNELS
from baselines.weighting.sgikf import SGIKF
from baselines.weighting.sikf import SIKF
from swarm_forage_env.foraging.control import observe_world
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.interface import EstimatorLayer, Kernel


def dead_reckoning(scenario: Scenario) -> EstimatorLayer:
    """Dead reckoning where robots forage: places with covariances, of which nobody is told."""
    numbers = CovarianceFilterParameters(speaks=False).numbers(scenario)
    kernels: dict[str, Kernel] = {**KERNELS, "take_in": take_in}
    own = SGIKF().layer(scenario)
    return EstimatorLayer(CovarianceMind, numbers, kernels, observe_world, own_weighting=own)


def covariance_intersection(scenario: Scenario) -> EstimatorLayer:
    """Covariance intersection where robots forage: places and ellipses, merged without overlap."""
    layer = CovarianceParameters().layer(scenario)
    numbers = {**layer.numbers, "intersects": 1.0}
    return replace(layer, numbers=numbers, own_weighting=SIKF().layer(scenario))


def decentralised_ekf(scenario: Scenario) -> EstimatorLayer:
    """The decentralised EKF where robots forage: a Kalman filter that knows the shared errors."""
    layer = CovarianceParameters().layer(scenario)
    kernels: dict[str, Kernel] = {
        **layer.kernels, "take_in": cross_covariance.take_in, "merge": cross_covariance.merge,
    }  # fmt: skip
    shared = (2, 2, 2)  # areas, then the 2 x 2 matrix of positions
    return replace(layer, mind=cross_covariance.CrossMind, kernels=kernels, shared=shared)
