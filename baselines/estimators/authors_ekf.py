"""The decentralised Kalman filter as the authors' code of BOIDS has it.

Smith et al. 2021 (BOIDS), Section 2.3, and the code that made its figures.

Every robot corrects itself alone, from what all had said before anybody was corrected. For each
pair are kept the factor of the cross-covariance and that factor as it was said.
"""

from baselines.estimators.boids_inputs import describe
from baselines.estimators.joint_update import (
    FilterMind,
    join,
    joint_gain,
    left_over,
    sight_jacobian,
    update_factors,
)
from baselines.estimators.pose_belief import PoseBelief
from baselines.estimators.pose_prediction import take_in_alone, tell
from baselines.estimators.small_matrices import copy3, product3_transposed, spectral_norm3
from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.compiler import kernel
from swarm_forage_env.equations.elementary import atan2, hypot
from swarm_forage_env.equations.geometry import wrap
from swarm_forage_env.interface import Kernel
from swarm_forage_env.record import Numbers, field
from swarm_forage_env.waypoints.records import Sighting

MAX_JUMP, MAX_GROWTH = 0.5, 1.0
"""The authors' code refuses a correction by as many metres, or that adds as much to |P|."""

FACTOR, SAID = 0, 1
"""What is kept for a pair: the factor, and the factor as it was said."""


class AuthorsMind(FilterMind):
    """All that the authors' filter keeps of a robot, but its factors."""

    said: PoseBelief = field(PoseBelief)
    """The estimate as it was told to the neighbours, before anybody was corrected."""


@kernel
def authors_bearing(measured: float, expected: float, dy: float) -> float:
    """The expected bearing as the authors' code compares it: with the other sign, if nearer.

    Where |dy| < 1 m the sign of the expected bearing is turned if that brings it nearer to the
    measured one, which stands in for wrapping the difference.

    Source: BOIDS, authors' code.
    """
    if abs(dy) < 1.0 and abs(measured - expected) >= abs(measured + expected):
        return -expected
    return expected


@kernel
def slipped_direction(mind: AuthorsMind, bearing: float) -> float:
    """The global direction of a sight, off by the error of the heading in the wrong sense [rad].

    Source: BOIDS, authors' code.
    """
    return wrap(bearing + (2.0 * mind.compass - mind.said.pose[2]))


@kernel
def correct_one(
    crowd: Array, shared: Array, i: int, j: int, sighting: Sighting, numbers: Numbers
) -> None:
    """Correct robot i alone by how it sees j, unless that moves it far.

    The half of robot j is thrown away. Both noises are the deviation of the range, and nothing
    keeps the joint matrix a covariance.

    Source: BOIDS, authors' code.
    """
    one, other, update = crowd[i].belief, crowd[j].said, crowd[i].update
    dx, dy = other.pose[0] - one.pose[0], other.pose[1] - one.pose[1]
    expected = hypot(dx, dy)
    if expected == 0.0:
        return
    product3_transposed(shared[i, j, FACTOR], shared[j, i, SAID], update.cross)
    join(one.P, other.P, update)
    sight_jacobian(dx, dy, 0.0, update.G)
    share = float(crowd[i].exchange.weight[0])
    joint_gain(update, share, numbers.range_noise, numbers.range_noise)
    direction = slipped_direction(crowd[i], float(sighting.bearing))
    along = float(sighting.range) - expected
    across = direction - authors_bearing(direction, atan2(dy, dx), dy)
    left_over(update.joint, update.G, update.K, update.half)
    if is_refused(crowd[i], along, across):
        return
    for a in range(3):
        one.pose[a] += update.K[a, 0] * along + update.K[a, 1] * across
        for b in range(3):
            one.P[a, b] = update.half[b, a]
    update_factors(update.before[0], one.P, update, shared[i, :, FACTOR])
    for a in range(3):
        for b in range(3):
            shared[i, j, FACTOR, a, b] = update.half[b + 3, a]


@kernel
def is_refused(mind: AuthorsMind, along: float, across: float) -> bool:
    """The correction would move the robot, or blow up its covariance, by too much.

    Source: BOIDS, authors' code.
    """
    update, after = mind.update, mind.update.products[0]
    for a in range(3):
        for b in range(3):
            after[a, b] = update.half[b, a]
    jump_x = update.K[0, 0] * along + update.K[0, 1] * across
    jump_y = update.K[1, 0] * along + update.K[1, 1] * across
    growth = spectral_norm3(after) - spectral_norm3(update.before[0])
    return hypot(jump_x, jump_y) >= MAX_JUMP or growth >= MAX_GROWTH


@kernel
def correct_each_alone(
    crowd: Array, shared: Float64[Array, "robots robots 2 3 3"], sightings: Array, numbers: Numbers
) -> None:
    """Every robot corrects itself by all that it sees, all from what was said before.

    Source: BOIDS, authors' code.
    """
    for i in range(crowd.shape[0]):
        tell(crowd[i].belief, crowd[i].said)
        for j in range(crowd.shape[0]):
            copy3(shared[i, j, FACTOR], shared[i, j, SAID])
    for i in range(crowd.shape[0]):
        for j in range(crowd.shape[0]):
            if sightings[i, j].seen:
                correct_one(crowd, shared, i, j, sightings[i, j], numbers)


AUTHORS_KERNELS: dict[str, Kernel] = {
    "take_in": take_in_alone,
    "describe": describe,
    "merge": correct_each_alone,
}
