"""The decentralised extended Kalman filter: relative updates with stored cross-correlations.

Smith et al. 2021 (BOIDS), Section II.1; Luft et al. 2016 and 2018.

Robot i keeps its pose x_i, its covariance P_i, and a factor s_ij for every other robot j, so that
P_ij = s_ij s_ji'. All factors start at zero. A pair's joint covariance is [P_i C; C' P_j]; the
first three rows are those of robot i.

In the authors' code every robot corrects only itself, from the estimates that all sent before any
correction; for each pair it keeps the factor, and the factor as sent.
"""

import math
from dataclasses import replace

import numpy as np

from baselines.estimators import cross_covariance
from baselines.estimators.base import ESTIMATORS
from baselines.estimators.covariance import CovarianceParameters
from baselines.estimators.cross_covariance import COHERENCE
from baselines.estimators.localisation import Localisation, waypoints_kernels
from baselines.estimators.pose_prediction import (
    PoseBelief,
    PoseMind,
    predict,
    reckon,
    step_slopes,
    update_belief_alone,
    visit_home,
)
from baselines.estimators.small_matrices import (
    Matrix3,
    cholesky3,
    identity3,
    inverse3,
    product3,
    product3_transposed,
    solve_lower3,
    spectral_norm3,
    transpose3,
)
from swarm_forage_env.arrays import Array, Float32, Float64
from swarm_forage_env.compiler import kernel
from swarm_forage_env.equations.elementary import atan2, hypot
from swarm_forage_env.equations.geometry import wrap
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.interface import EstimatorLayer, Kernel
from swarm_forage_env.record import Numbers, Record, field
from swarm_forage_env.waypoints.records import SPEED, Readings, Sighting
from swarm_forage_env.waypoints.scenario import WaypointsScenario

MAX_JUMP, MAX_GROWTH = 0.5, 1.0
"""Jump [m] and growth of |P| from which the authors' code refuses a correction."""

NEAREST = 1e-3  # least distance at which a sighting is used [m] (chosen)
FACTOR, SENT = 0, 1  # memory of a pair: the factor, and the factor as sent

Factors = Float64[Array, "robots 3 3"]  # s_ij of robot i for each robot j
Joint = Float64[Array, "6 6"]
Jacobian = Float64[Array, "2 6"]
Gain = Float64[Array, "6 2"]


class JointUpdate(Record):
    """Working space of one relative update."""

    cross: Matrix3 = field(np.float64, 3, 3)
    """C, the cross-covariance of the pair."""
    joint: Joint = field(np.float64, 6, 6)
    """The covariance of the pair before the update."""
    half: Joint = field(np.float64, 6, 6)
    """((I - K G) P)'."""
    after: Joint = field(np.float64, 6, 6)
    """The covariance of the pair after the update."""
    G: Jacobian = field(np.float64, 2, 6)
    """Jacobian of range and bearing by both poses."""
    K: Gain = field(np.float64, 6, 2)
    """The gain."""
    before: Float64[Array, "pair 3 3"] = field(np.float64, 2, 3, 3)
    """Covariance of each robot before the update."""
    L: Matrix3 = field(np.float64, 3, 3)
    """Lower triangle with L L' = P."""
    products: Float64[Array, "4 3 3"] = field(np.float64, 4, 3, 3)
    """Intermediate products."""


class FilterMind(PoseMind):
    """State of a robot under the decentralised Kalman filter, without its factors."""

    update: JointUpdate = field(JointUpdate)


@kernel
def sight_jacobian(dx: float, dy: float, by_heading: float, out_G: Jacobian) -> None:
    """Write the Jacobian by both poses of the range and bearing at which i sees j.

        G_i = [-dx/r -dy/r 0; dy/r^2 -dx/r^2 -1],  G_j = [dx/r dy/r 0; -dy/r^2 dx/r^2 0]

    (dx, dy) = x_j - x_i [m]; `by_heading`: -1 for a bearing of the body frame, 0 for a global one.

    Source: BOIDS, Eq. 15, which does not write G out; authors' code, for 0.
    """
    r2 = dx * dx + dy * dy
    r = math.sqrt(r2)
    out_G[0, 2] = out_G[0, 5] = out_G[1, 5] = 0.0
    out_G[0, 0], out_G[0, 1], out_G[0, 3], out_G[0, 4] = -dx / r, -dy / r, dx / r, dy / r
    out_G[1, 0], out_G[1, 1], out_G[1, 3], out_G[1, 4] = dy / r2, -dx / r2, -dy / r2, dx / r2
    out_G[1, 2] = by_heading


@kernel
def joint_gain(update: JointUpdate, g: float, var_range: float, var_bearing: float) -> None:
    """Write the gain of a relative measurement for both poses, scaled by g.

        K = g P G' (G P G' + R)^-1,  R = diag(var_range, var_bearing)

    Source: BOIDS, Eq. 15.
    """
    G, K = update.G, update.K
    for a in range(6):
        for k in range(2):
            K[a, k] = 0.0
            for b in range(6):
                K[a, k] += update.joint[a, b] * G[k, b]
    s00, s01, s11 = var_range, 0.0, var_bearing
    for b in range(6):
        s00 += G[0, b] * K[b, 0]
        s01 += G[0, b] * K[b, 1]
        s11 += G[1, b] * K[b, 1]
    scale = 1.0 / (s00 * s11 - s01 * s01)
    for a in range(6):
        k0, k1 = K[a, 0], K[a, 1]
        K[a, 0] = scale * (k0 * s11 - k1 * s01) * g
        K[a, 1] = scale * (k1 * s00 - k0 * s01) * g


@kernel
def joseph_half(A: Joint, G: Jacobian, K: Gain, out: Joint) -> None:
    """Write ((I - K G) A)', transposed so that two calls give (I - K G) A (I - K G)'."""
    for b in range(6):
        seen_range, seen_bearing = 0.0, 0.0
        for c in range(6):
            seen_range += G[0, c] * A[c, b]
            seen_bearing += G[1, c] * A[c, b]
        for a in range(6):
            out[b, a] = A[a, b] - K[a, 0] * seen_range - K[a, 1] * seen_bearing


@kernel
def correct_joint(update: JointUpdate, var_range: float, var_bearing: float) -> None:
    """Write the covariance of both poses after the update; positive semi-definite for any gain.

        P = (I - K G) P (I - K G)' + K R K'

    Source: BucyJoseph1968, for BOIDS, Eq. 17.
    """
    G, K, after = update.G, update.K, update.after
    joseph_half(update.joint, G, K, update.half)
    joseph_half(update.half, G, K, after)
    for a in range(6):
        for b in range(a + 1):
            noise = var_range * K[a, 0] * K[b, 0] + var_bearing * K[a, 1] * K[b, 1]
            after[a, b] = after[b, a] = 0.5 * (after[a, b] + after[b, a]) + noise


@kernel
def bound_correlation(P_i: Matrix3, P_j: Matrix3, update: JointUpdate) -> None:
    """Shrink the cross-covariance C, in place, to the bound set by the two covariances.

        |L_i^-1 C L_j^-T| <= COHERENCE,  L L' = P

    Luft's factors only approximate C once other robots have corrected either robot, and C may then
    exceed the bound: the joint matrix would be no covariance.

    Source: HornJohnson2012, Theorem 7.7.7.
    """
    L, C = update.L, update.cross
    half, turned = update.products[0], update.products[1]
    M, square = update.products[2], update.products[3]
    cholesky3(P_i, L)
    solve_lower3(L, C, half)
    transpose3(half, turned)
    cholesky3(P_j, L)
    solve_lower3(L, turned, M)
    product3_transposed(M, M, square)
    most = math.sqrt(spectral_norm3(square))
    if most > COHERENCE:
        for a in range(3):
            for b in range(3):
                C[a, b] *= COHERENCE / most


@kernel
def join(P_i: Matrix3, P_j: Matrix3, update: JointUpdate) -> None:
    """Write the joint covariance [P_i C; C' P_j], and copy P_i and P_j to `before`."""
    C, joint, before = update.cross, update.joint, update.before
    for a in range(3):
        for b in range(3):
            joint[a, b] = before[0, a, b] = P_i[a, b]
            joint[a, b + 3] = C[a, b]
            joint[a + 3, b] = C[b, a]
            joint[a + 3, b + 3] = before[1, a, b] = P_j[a, b]


@kernel
def multiply_factors(M: Matrix3, factors: Factors) -> None:
    """Multiply s_ih by M for every robot h, in place; written out, as it takes most of the time."""
    for h in range(factors.shape[0]):
        for k in range(3):
            a, b, c = factors[h, 0, k], factors[h, 1, k], factors[h, 2, k]
            factors[h, 0, k] = M[0, 0] * a + M[0, 1] * b + M[0, 2] * c
            factors[h, 1, k] = M[1, 0] * a + M[1, 1] * b + M[1, 2] * c
            factors[h, 2, k] = M[2, 0] * a + M[2, 1] * b + M[2, 2] * c


@kernel
def update_factors(before: Matrix3, after: Matrix3, update: JointUpdate, factors: Factors) -> None:
    """Update the factors of a robot after its covariance was corrected from Q to P, in place.

        s_ih = P Q^-1 s_ih

    Source: BOIDS, Eq. 20; Luft2018, Eq. 16.
    """
    undo, ratio = update.products[0], update.products[1]
    inverse3(before, undo)
    product3(after, undo, ratio)
    multiply_factors(ratio, factors)


@kernel
def authors_bearing(measured: float, expected: float, dy: float) -> float:
    """Return the expected bearing as in the authors' code: with the opposite sign, if nearer.

    Where |dy| < 1 m, the code changes the sign if that brings the bearing nearer to the measured
    one, instead of wrapping the difference.

    Source: BOIDS, authors' code.
    """
    if abs(dy) < 1.0 and abs(measured - expected) >= abs(measured + expected):
        return -expected
    return expected


@kernel
def slipped_direction(mind: FilterMind, bearing: float) -> float:
    """Return the global direction of a sighting, off by the negated heading error [rad].

    Source: BOIDS, authors' code.
    """
    return wrap(bearing + (2.0 * mind.compass - mind.sent.pose[2]))


@kernel
def correct_one(
    minds: Array, shared: Array, i: int, j: int, sighting: Sighting, numbers: Numbers
) -> None:
    """Correct only robot i by its sighting of j, unless the correction is refused.

    The correction of robot j is dropped. Both noises are the standard deviation of the range, and
    the joint matrix may be no covariance.

    Source: BOIDS, authors' code.
    """
    one, other, update = minds[i].belief, minds[j].sent, minds[i].update
    dx, dy = other.pose[0] - one.pose[0], other.pose[1] - one.pose[1]
    expected = hypot(dx, dy)
    if expected == 0.0:
        return
    product3_transposed(shared[i, j, FACTOR], shared[j, i, SENT], update.cross)
    join(one.P, other.P, update)
    sight_jacobian(dx, dy, 0.0, update.G)
    share = float(minds[i].exchange.weight[0])
    joint_gain(update, share, numbers.range_noise, numbers.range_noise)
    direction = slipped_direction(minds[i], float(sighting.bearing))
    along = float(sighting.range) - expected
    across = direction - authors_bearing(direction, atan2(dy, dx), dy)
    joseph_half(update.joint, update.G, update.K, update.half)
    if is_refused(minds[i], along, across):
        return
    for a in range(3):
        one.pose[a] += update.K[a, 0] * along + update.K[a, 1] * across
    transpose3(update.half, one.P)
    update_factors(update.before[0], one.P, update, shared[i, :, FACTOR])
    transpose3(update.half[3:], shared[i, j, FACTOR])


@kernel
def is_refused(mind: FilterMind, along: float, across: float) -> bool:
    """Return whether the correction moves the robot, or increases its covariance, by too much.

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
    """Correct every robot by its own sightings, from the estimates sent before any correction.

    Source: BOIDS, authors' code.
    """
    for i in range(minds.shape[0]):
        minds[i].sent = minds[i].belief
        for j in range(minds.shape[0]):
            for a in range(3):
                for b in range(3):
                    shared[i, j, SENT, a, b] = shared[i, j, FACTOR, a, b]
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

    Source: BOIDS, Eq. 5 to 11, whose last left side must be s_ij.
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

    Source: BOIDS, Eq. 16.
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

    Source: BOIDS, Eq. 12 to 20; Luft2018, Section 3.4.
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
    """Correct both robots of every sighting, in the order of their indices."""
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
        """Return the layer that corrects poses by range and bearing of the robots seen."""
        layer = super().waypoints_layer(scenario)
        if self.setting != "authors":
            return replace(layer, shared=(3, 3))
        kernels = waypoints_kernels(update_belief_alone, correct_each_alone)
        return replace(layer, kernels=kernels, shared=(2, 3, 3))

    def foraging_layer(self, scenario: Scenario) -> EstimatorLayer:
        """Return the layer of social odometry that corrects with cross-covariances."""
        layer = CovarianceParameters().layer(scenario)
        kernels: dict[str, Kernel] = {
            **layer.kernels,
            "update_belief": cross_covariance.update_belief,
            "merge": cross_covariance.merge,
        }
        shared = (2, 2, 2)  # areas, then the 2 x 2 matrix of positions
        return replace(layer, mind=cross_covariance.CrossMind, kernels=kernels, shared=shared)
