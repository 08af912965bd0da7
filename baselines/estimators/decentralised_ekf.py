"""The decentralised extended Kalman filter: relative updates with stored cross-correlations.

Smith et al. 2021 (BOIDS), Section 2.3; Luft et al. 2016 and 2018.

Robot i keeps its pose x_i, its covariance P_i, and a factor s_ij for every other robot j, so that
P_ij = s_ij s_ji'. All factors start at zero.

In the authors' code every robot corrects itself alone, from what all said before any correction;
for each pair it keeps the factor, and the factor as said.
"""

from dataclasses import replace

from baselines.estimators import cross_covariance
from baselines.estimators.base import ESTIMATORS
from baselines.estimators.covariance import CovarianceParameters
from baselines.estimators.joint_update import (
    Factors,
    FilterMind,
    bound_correlation,
    correct_joint,
    join,
    joint_gain,
    left_over,
    multiply_factors,
    sight_jacobian,
    update_factors,
)
from baselines.estimators.localisation import Localisation, waypoints_kernels
from baselines.estimators.pose_prediction import (
    PoseBelief,
    predict,
    reckon,
    step_slopes,
    update_belief_alone,
    visit_home,
)
from baselines.estimators.small_matrices import (
    identity3,
    product3_transposed,
    spectral_norm3,
    transpose3,
)
from swarm_forage_env.arrays import Array, Float32, Float64
from swarm_forage_env.compiler import kernel
from swarm_forage_env.equations.elementary import atan2, hypot
from swarm_forage_env.equations.geometry import wrap
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.interface import EstimatorLayer, Kernel
from swarm_forage_env.record import Numbers
from swarm_forage_env.waypoints.records import SPEED, Readings, Sighting
from swarm_forage_env.waypoints.scenario import WaypointsScenario

MAX_JUMP, MAX_GROWTH = 0.5, 1.0
"""Corrections that the authors' code refuses: by this far [m], or that increase |P| by this."""

NEAREST = 1e-3  # least distance at which a bearing tells two robots apart [m] (chosen)
FACTOR, SAID = 0, 1  # memory of a pair: the factor, and the factor as said


@kernel
def authors_bearing(measured: float, expected: float, dy: float) -> float:
    """The expected bearing as the authors' code compares it: with the opposite sign, if nearer.

    Where |dy| < 1 m the sign is changed if that brings it nearer to the measured bearing, instead
    of wrapping the difference.

    Source: BOIDS, authors' code.
    """
    if abs(dy) < 1.0 and abs(measured - expected) >= abs(measured + expected):
        return -expected
    return expected


@kernel
def slipped_direction(mind: FilterMind, bearing: float) -> float:
    """The global direction of a sighting, off by the heading's error with the wrong sign [rad].

    Source: BOIDS, authors' code.
    """
    return wrap(bearing + (2.0 * mind.compass - mind.said.pose[2]))


@kernel
def correct_one(
    minds: Array, shared: Array, i: int, j: int, sighting: Sighting, numbers: Numbers
) -> None:
    """Correct robot i alone by its sighting of j, unless the correction is refused.

    The half of robot j is dropped. Both noises are the deviation of the range, and nothing keeps
    the joint matrix a covariance.

    Source: BOIDS, authors' code.
    """
    one, other, update = minds[i].belief, minds[j].said, minds[i].update
    dx, dy = other.pose[0] - one.pose[0], other.pose[1] - one.pose[1]
    expected = hypot(dx, dy)
    if expected == 0.0:
        return
    product3_transposed(shared[i, j, FACTOR], shared[j, i, SAID], update.cross)
    join(one.P, other.P, update)
    sight_jacobian(dx, dy, 0.0, update.G)
    share = float(minds[i].exchange.weight[0])
    joint_gain(update, share, numbers.range_noise, numbers.range_noise)
    direction = slipped_direction(minds[i], float(sighting.bearing))
    along = float(sighting.range) - expected
    across = direction - authors_bearing(direction, atan2(dy, dx), dy)
    left_over(update.joint, update.G, update.K, update.half)
    if is_refused(minds[i], along, across):
        return
    for a in range(3):
        one.pose[a] += update.K[a, 0] * along + update.K[a, 1] * across
    transpose3(update.half, one.P)
    update_factors(update.before[0], one.P, update, shared[i, :, FACTOR])
    transpose3(update.half[3:], shared[i, j, FACTOR])


@kernel
def is_refused(mind: FilterMind, along: float, across: float) -> bool:
    """The correction would move the robot, or increase its covariance, by too much.

    Source: BOIDS, authors' code.
    """
    update, after = mind.update, mind.update.products[0]
    transpose3(update.half, after)
    jump_x = update.K[0, 0] * along + update.K[0, 1] * across
    jump_y = update.K[1, 0] * along + update.K[1, 1] * across
    growth = spectral_norm3(after) - spectral_norm3(update.before[0])
    return hypot(jump_x, jump_y) >= MAX_JUMP or growth >= MAX_GROWTH


@kernel
def correct_each_alone(
    minds: Array, shared: Float64[Array, "robots robots 2 3 3"], sightings: Array, numbers: Numbers
) -> None:
    """Every robot corrects itself by all its sightings, from what was said before.

    Source: BOIDS, authors' code.
    """
    for i in range(minds.shape[0]):
        minds[i].said = minds[i].belief
        for j in range(minds.shape[0]):
            for a in range(3):
                for b in range(3):
                    shared[i, j, SAID, a, b] = shared[i, j, FACTOR, a, b]
    for i in range(minds.shape[0]):
        for j in range(minds.shape[0]):
            if sightings[i, j].seen:
                correct_one(minds, shared, i, j, sightings[i, j], numbers)


@kernel
def propagate_factors(
    belief: PoseBelief, motion: Float32[Array, "2"], dt: float, factors: Factors
) -> None:
    """Propagate the factors of a robot by the step that led to its pose, in place.

        s_ij = F s_ij

    Source: BOIDS, Eq. 7.
    """
    u, v = step_slopes(float(motion[SPEED]) * dt, belief.pose[2])
    for j in range(factors.shape[0]):
        for k in range(3):
            factors[j, 0, k] += u * factors[j, 2, k]
            factors[j, 1, k] += v * factors[j, 2, k]


@kernel
def update_belief(mind: FilterMind, factors: Factors, readings: Readings, numbers: Numbers) -> None:
    """Update estimate and factors by the robot's own readings.

    A fix at home multiplies the factors: s_ij = (I - K) s_ij.

    Source: BOIDS, Eq. 6 to 12, whose last left side must be s_ij.
    """
    reckon(mind, readings, numbers)
    predict(mind.belief, readings.motion, numbers)
    propagate_factors(mind.belief, readings.motion, numbers.dt, factors)
    visit_home(mind.belief, readings, mind.home, numbers)
    if readings.at_home:
        multiply_factors(mind.home.rest, factors)
    mind.covariance_norm = spectral_norm3(mind.belief.P)


@kernel
def move_pair(one: FilterMind, other: FilterMind, far: float, bearing: float) -> None:
    """Correct two poses by a range [m] and bearing [rad], and copy their corrected covariances.

        x = x + g K (z - h(x))

    Source: BOIDS, Eq. 18.
    """
    update, pose_i, pose_j = one.update, one.belief.pose, other.belief.pose
    K, after = update.K, update.after
    dx, dy = pose_j[0] - pose_i[0], pose_j[1] - pose_i[1]
    along = far - hypot(dx, dy)
    across = wrap(bearing - (atan2(dy, dx) - pose_i[2]))
    for a in range(3):
        pose_i[a] += K[a, 0] * along + K[a, 1] * across
        pose_j[a] += K[a + 3, 0] * along + K[a + 3, 1] * across
        for b in range(3):
            one.belief.P[a, b], other.belief.P[a, b] = after[a, b], after[a + 3, b + 3]
    pose_i[2], pose_j[2] = wrap(pose_i[2]), wrap(pose_j[2])


@kernel
def correct_both(
    minds: Array, factors: Array, i: int, j: int, sighting: Sighting, numbers: Numbers
) -> None:
    """Correct robots i and j, and their factors, by the sighting of j by i, scaled by g.

        x = x + g K (z - h(x))
        s_ij = P_ij,  s_ji = I

    Source: BOIDS, Eq. 13 to 20; Luft2018, Section 3.4.
    """
    one, other, update = minds[i].belief, minds[j].belief, minds[i].update
    dx, dy = other.pose[0] - one.pose[0], other.pose[1] - one.pose[1]
    if hypot(dx, dy) < NEAREST:
        return
    product3_transposed(factors[i, j], factors[j, i], update.cross)
    bound_correlation(one.P, other.P, update)
    join(one.P, other.P, update)
    sight_jacobian(dx, dy, -1.0, update.G)
    var_range, var_bearing = numbers.range_noise**2, numbers.bearing_noise**2
    joint_gain(update, float(minds[i].exchange.weight[0]), var_range, var_bearing)
    correct_joint(update, var_range, var_bearing)
    move_pair(minds[i], minds[j], float(sighting.range), float(sighting.bearing))
    update_factors(update.before[0], one.P, update, factors[i])
    update_factors(update.before[1], other.P, update, factors[j])
    for a in range(3):
        for b in range(3):
            factors[i, j, a, b] = update.after[a, b + 3]
    identity3(1.0, factors[j, i])


@kernel
def correct_by_sight(
    minds: Array, factors: Float64[Array, "robots robots 3 3"], sightings: Array, numbers: Numbers
) -> None:
    """Every sighting corrects both robots, in the order of their numbers."""
    for i in range(minds.shape[0]):
        for j in range(minds.shape[0]):
            if sightings[i, j].seen:
                correct_both(minds, factors, i, j, sightings[i, j], numbers)


@ESTIMATORS.register("decentralised_ekf")
class DecentralisedEKF(Localisation):
    """Decentralised Kalman filter: a sighting corrects both robots and their cross-covariance."""

    mind = FilterMind
    kernels = waypoints_kernels(update_belief, correct_by_sight)

    def waypoints_layer(self, scenario: WaypointsScenario) -> EstimatorLayer:
        """Poses corrected by range and bearing of the robots seen."""
        layer = super().waypoints_layer(scenario)
        if self.setting != "authors":
            return replace(layer, shared=(3, 3))
        kernels = waypoints_kernels(update_belief_alone, correct_each_alone)
        return replace(layer, kernels=kernels, shared=(2, 3, 3))

    def foraging_layer(self, scenario: Scenario) -> EstimatorLayer:
        """Social odometry whose estimates are corrected with their cross-covariances."""
        layer = CovarianceParameters().layer(scenario)
        kernels: dict[str, Kernel] = {
            **layer.kernels,
            "update_belief": cross_covariance.update_belief,
            "merge": cross_covariance.merge,
        }
        shared = (2, 2, 2)  # areas, then the 2 x 2 matrix of positions
        return replace(layer, mind=cross_covariance.CrossMind, kernels=kernels, shared=shared)
