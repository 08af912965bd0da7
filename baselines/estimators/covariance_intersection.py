"""Fast covariance intersection of a robot's and its neighbours' estimates of its pose.

Smith et al. 2021 (BOIDS), Section II.1; Fraenken and Huepper 2005.
"""

import math
from dataclasses import replace

import numpy as np

from baselines.estimators.base import ESTIMATORS
from baselines.estimators.covariance import CovarianceParameters
from baselines.estimators.localisation import Localisation, waypoints_kernels
from baselines.estimators.pose_prediction import (
    PoseBelief,
    PoseMind,
    propagate,
    step_slopes,
    update_belief_alone,
)
from baselines.estimators.small_matrices import Matrix3, determinant3, identity3, inverse3
from baselines.weighting.sikf import SIKF
from swarm_forage_env.arrays import Array
from swarm_forage_env.compiler import kernel
from swarm_forage_env.equations.elementary import cos_sin
from swarm_forage_env.equations.geometry import Pose, wrap
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.interface import EstimatorLayer
from swarm_forage_env.record import Numbers, Record, field


class Entry(Record):
    """Estimate of a pose that enters a fusion: the robot's own, or a neighbour's."""

    pose: Pose = field(np.float64, 3, unit="m, m, rad")
    P: Matrix3 = field(np.float64, 3, 3)
    """Covariance of the pose."""
    inverse: Matrix3 = field(np.float64, 3, 3)
    """Inverse of the covariance."""
    weight: float = field(np.float64)
    """Weight in the fusion."""


class IntersectionMind(PoseMind):
    """State of a robot under covariance intersection."""

    entry: Entry = field(Entry)
    """Working space: an entry of the list of estimates to fuse, which has an entry per robot."""
    total: Matrix3 = field(np.float64, 3, 3)
    """Working space: a sum over the list."""
    rest: Matrix3 = field(np.float64, 3, 3)
    """Working space: the sum without one of its terms."""


@kernel
def weigh_estimates(minds: Array, n: int, S: Matrix3, rest: Matrix3) -> None:
    """Write the weights of the first n estimates of the list, in closed form; they sum to one.

        I_q = (P^q)^-1,   S = sum_q I_q
        w_j = (det S - det(S - I_j) + det I_j)
              / (L det S + sum_q [det I_q - det(S - I_q)])

    The paper prints P instead of its inverse.

    Source: BOIDS, Eq. 3 and 4; Fraenken2005, Eq. 16.
    """
    identity3(0.0, S)
    for q in range(n):
        for a in range(3):
            for b in range(3):
                S[a, b] += minds[q].entry.inverse[a, b]
    det_S, total = determinant3(S), 0.0
    for j in range(n):
        inverse = minds[j].entry.inverse
        for a in range(3):
            for b in range(3):
                rest[a, b] = S[a, b] - inverse[a, b]
        minds[j].entry.weight = det_S - determinant3(rest) + determinant3(inverse)
        total += minds[j].entry.weight
    for j in range(n):
        minds[j].entry.weight /= total


@kernel
def place_of_neighbour(x: float, y: float, far: float, direction: float) -> tuple[float, float]:
    """Return the position of a robot at range `far` [m] and global direction [rad] from (x, y).

    Source: BOIDS, authors' code, for x_i^j of Eq. 1.
    """
    c, s = cos_sin(direction)
    return x + far * c, y + far * s


@kernel
def add_sight_noise(
    far: float, direction: float, var_range: float, var_bearing: float, P: Matrix3
) -> None:
    """Turn the covariance P of robot j into that of its estimate of a robot it sees, in place.

        P = T P T' + W diag(s_r^2, s_b^2, s_b^2) W'
        T = [1 0 -r sin(d); 0 1 r cos(d); 0 0 1]
        W = [cos(d) -r sin(d) 0; sin(d) r cos(d) 0; 0 1 -1]

    r is the range and d the global direction. The heading follows from the bearings at which the
    two robots see each other.

    Source: textbook (propagation of errors), for P_i^j of BOIDS, Eq. 2.
    """
    u, v = step_slopes(far, direction)
    propagate(P, u, v)
    c, s = cos_sin(direction)
    across = far * far * var_bearing
    P[0, 0] += var_range * c * c + across * s * s
    P[1, 1] += var_range * s * s + across * c * c
    P[0, 1] += (var_range - across) * c * s
    P[0, 2] -= var_bearing * far * s
    P[1, 2] += var_bearing * far * c
    P[2, 2] += 2.0 * var_bearing
    P[1, 0], P[2, 0], P[2, 1] = P[0, 1], P[0, 2], P[1, 2]


@kernel
def hear_pose(minds: Array, i: int, j: int, sightings: Array, numbers: Numbers, out: Entry) -> None:
    """Write robot j's estimate of the pose of robot i, which it sees, and its covariance.

    Heading: theta_i = theta_j + b_ji + pi - b_ij, by the bearings at which they see each other.
    The authors' code has a sign error: its global directions are off by the heading error with the
    wrong sign. Its noise is a diagonal of standard deviations.
    """
    far, back = float(sightings[j, i].range), float(sightings[j, i].bearing)
    bearing = float(sightings[i, j].bearing)
    out.P = minds[j].sent.P
    own, other, P = minds[i].sent.pose, minds[j].sent.pose, out.P
    if numbers.authors > 0.0:
        direction = back + 2.0 * minds[j].compass - other[2]
        ahead = bearing + 2.0 * minds[i].compass - own[2]
        out.pose[2] = own[2] - wrap(direction + math.pi - ahead)
        P[0, 0] += numbers.range_noise
        P[1, 1] += numbers.range_noise
        P[2, 2] += numbers.bearing_noise
    else:
        direction = back + other[2]
        heading = other[2] + back + math.pi - bearing
        out.pose[2] = own[2] + wrap(heading - own[2])
        add_sight_noise(far, direction, numbers.range_noise**2, numbers.bearing_noise**2, P)
    out.pose[0], out.pose[1] = place_of_neighbour(other[0], other[1], far, direction)


@kernel
def fuse(minds: Array, n: int, information: Matrix3, out: PoseBelief) -> None:
    """Write the weighted intersection of the first n estimates of the list.

        P = (sum_j w_j I_j)^-1
        x = P sum_j w_j I_j x^j

    Source: BOIDS, Eq. 1 and 2.
    """
    identity3(0.0, information)
    vx, vy, vt = 0.0, 0.0, 0.0
    for q in range(n):
        w, info, x = minds[q].entry.weight, minds[q].entry.inverse, minds[q].entry.pose
        for a in range(3):
            for b in range(3):
                information[a, b] += w * info[a, b]
        vx += w * (info[0, 0] * x[0] + info[0, 1] * x[1] + info[0, 2] * x[2])
        vy += w * (info[1, 0] * x[0] + info[1, 1] * x[1] + info[1, 2] * x[2])
        vt += w * (info[2, 0] * x[0] + info[2, 1] * x[1] + info[2, 2] * x[2])
    inverse3(information, out.P)
    for a in range(3):
        out.pose[a] = out.P[a, 0] * vx + out.P[a, 1] * vy + out.P[a, 2] * vt


@kernel
def list_estimates(minds: Array, i: int, sightings: Array, numbers: Numbers) -> int:
    """List robot i's own estimate and those by robots in mutual sight; return their number."""
    entry, sent, n = minds[0].entry, minds[i].sent, 1
    inverse3(sent.P, entry.inverse)
    entry.pose = sent.pose
    for j in range(minds.shape[0]):
        if sightings[i, j].seen and sightings[j, i].seen:
            entry = minds[n].entry
            hear_pose(minds, i, j, sightings, numbers, entry)
            inverse3(entry.P, entry.inverse)
            n += 1
    return n


@kernel
def intersect(minds: Array, shared: Array, sightings: Array, numbers: Numbers) -> None:
    """Fuse every robot's estimate of its pose with its neighbours' estimates of it.

    The weight g in [0, 1] scales a correction: it multiplies the weights of the neighbours, and the
    own estimate gets the rest, which is a covariance intersection too. In the authors' code a robot
    with a single neighbour is not corrected.

    Source: BOIDS, Eq. 1 to 4.
    """
    least = 2 if numbers.authors > 0.0 else 1
    for i in range(minds.shape[0]):
        minds[i].sent = minds[i].belief
    for i in range(minds.shape[0]):
        n = list_estimates(minds, i, sightings, numbers)
        if n <= least:
            continue
        weigh_estimates(minds, n, minds[i].total, minds[i].rest)
        share = float(minds[i].exchange.weight[0])
        for q in range(n):
            minds[q].entry.weight *= share
        minds[0].entry.weight += 1.0 - share
        fuse(minds, n, minds[i].total, minds[i].belief)


@ESTIMATORS.register("covariance_intersection")
class CovarianceIntersection(Localisation):
    """Covariance intersection: consistent fusion of estimates of unknown correlation."""

    mind = IntersectionMind
    kernels = waypoints_kernels(update_belief_alone, intersect)

    def foraging_layer(self, scenario: Scenario) -> EstimatorLayer:
        """Return the layer of social odometry that fuses by covariance intersection."""
        layer = CovarianceParameters().layer(scenario)
        numbers = {**layer.numbers, "intersects": 1.0}
        return replace(layer, numbers=numbers, own_weighting=SIKF().layer(scenario))
