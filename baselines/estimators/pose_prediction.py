"""Prediction, and correction at home: the part common to all estimators of a pose.

Smith et al. 2021 (BOIDS), Section II.1.
"""

import numpy as np

from baselines.estimators.small_matrices import (
    Matrix3,
    identity3,
    inverse3,
    product3,
    product3_transposed,
    spectral_norm3,
    symmetrise3,
)
from swarm_forage_env.arrays import Array, Float32, Float64
from swarm_forage_env.compiler import kernel
from swarm_forage_env.equations.elementary import cos_sin
from swarm_forage_env.equations.geometry import Pose, wrap
from swarm_forage_env.record import Numbers, Record, field
from swarm_forage_env.waypoints.records import SPEED, TURN, Exchange, Readings, Situation

START_VARIANCE = 0.1
"""Variance of x, y [m^2], heading [rad^2] at the start and, in the authors' code, at home."""


class PoseBelief(Record):
    """Estimate of the robot's own pose, world frame."""

    pose: Pose = field(np.float64, 3, unit="m, m, rad")
    """x, y [m] and heading [rad]."""
    P: Matrix3 = field(np.float64, 3, 3, start=START_VARIANCE * np.eye(3))
    """Covariance of the pose."""
    velocity: Float64[Array, "2"] = field(np.float64, 2, unit="m/s")
    """Measured velocity of the last tick."""


class NeighbourMeans(Record):
    """Means and a sum over the neighbours' beliefs. Writer: `sum_neighbours`."""

    position: Float64[Array, "2"] = field(np.float64, 2, unit="m")
    """Mean position."""
    velocity: Float64[Array, "2"] = field(np.float64, 2, unit="m/s")
    """Mean velocity."""
    away: Float64[Array, "2"] = field(np.float64, 2, unit="m")
    """Sum of the displacements from the neighbours."""


class HomeUpdate(Record):
    """Working space of a correction by a fix at home. Writer: `correct_privately`."""

    innovation: Matrix3 = field(np.float64, 3, 3)
    """Covariance of the innovation, P + R."""
    gain: Matrix3 = field(np.float64, 3, 3)
    """K."""
    rest: Matrix3 = field(np.float64, 3, 3)
    """I - K."""
    half: Matrix3 = field(np.float64, 3, 3)
    """Intermediate products."""


class PoseMind(Record):
    """State of a robot under dead reckoning; the filters extend it."""

    belief: PoseBelief = field(PoseBelief)
    """Estimate with all corrections."""
    reckoned: PoseBelief = field(PoseBelief)
    """Estimate without neighbours: dead reckoning between visits at home."""
    sent: PoseBelief = field(PoseBelief)
    """Estimate as sent to the neighbours, before any correction by them."""
    compass: float = field(np.float32, unit="rad")
    """Heading without error in this tick. Writer: `update_belief`."""
    covariance_norm: float = field(np.float64)
    """Spectral norm of the covariance of the estimate. Writer: `update_belief`."""
    neighbours: NeighbourMeans = field(NeighbourMeans)
    home: HomeUpdate = field(HomeUpdate)
    exchange: Exchange = field(Exchange)
    situation: Situation = field(Situation)


@kernel
def step_slopes(along: float, theta: float) -> tuple[float, float]:
    """Return the derivatives u, v of a position x, y by the heading, for a step or a sighting.

        F = [1 0 u; 0 1 v; 0 0 1],  u = -V dt sin(theta),  v = V dt cos(theta)

    `along` = V dt [m]; theta is the heading after the turn [rad]. F is the derivative of the pose
    after the step by the pose before it.

    Source: BOIDS, Eq. 6, for F; authors' code, whose robots turn before they go.
    """
    c, s = cos_sin(theta)
    return -along * s, along * c


@kernel
def propagate(P: Matrix3, u: float, v: float) -> None:
    """Propagate P = F P F' with F = [1 0 u; 0 1 v; 0 0 1], in place.

    Source: BOIDS, Eq. 6.
    """
    for k in range(3):
        P[0, k] += u * P[2, k]
        P[1, k] += v * P[2, k]
    for k in range(3):
        P[k, 0] += u * P[k, 2]
        P[k, 1] += v * P[k, 2]


@kernel
def add_step_noise(
    along: float, theta: float, dt: float, var_speed: float, var_turn: float, P: Matrix3
) -> None:
    """Add the covariance of errors of the measured speed and turn rate, in place.

        P = P + W diag(s_V^2, s_w^2) W'
        W = [ dt cos(theta)   -V dt^2 sin(theta)
              dt sin(theta)    V dt^2 cos(theta)
              0                dt ]

    Source: BOIDS, Eq. 5, differentiated by its inputs (not in the paper).
    """
    c, s = cos_sin(theta)
    of_speed = var_speed, dt * c, dt * s, 0.0
    of_turn = var_turn, -along * dt * s, along * dt * c, dt
    for variance, x, y, t in (of_speed, of_turn):
        P[0, 0] += variance * x * x
        P[1, 1] += variance * y * y
        P[2, 2] += variance * t * t
        P[0, 1] += variance * x * y
        P[0, 2] += variance * x * t
        P[1, 2] += variance * y * t
    P[1, 0], P[2, 0], P[2, 1] = P[0, 1], P[0, 2], P[1, 2]


@kernel
def predict(belief: PoseBelief, motion: Float32[Array, "2"], numbers: Numbers) -> None:
    """Move an estimate by the measured motion, and grow its covariance.

        x = f(x, u)
        P = F P F' + Q

    Q is that of `add_step_noise` or, in the authors' code, diag(s_V, s_V, s_w): standard deviations
    instead of variances, without the time step.

    Source: BOIDS, Eq. 5 and 6.
    """
    dt, pose, velocity, P = numbers.dt, belief.pose, belief.velocity, belief.P
    speed, turn = float(motion[SPEED]), float(motion[TURN])
    theta = wrap(pose[2] + turn * dt)
    c, s = cos_sin(theta)
    velocity[0], velocity[1] = speed * c, speed * s
    pose[0] += velocity[0] * dt
    pose[1] += velocity[1] * dt
    pose[2] = theta
    u, v = step_slopes(speed * dt, theta)
    propagate(P, u, v)
    if numbers.authors > 0.0:
        P[0, 0] += numbers.speed_noise
        P[1, 1] += numbers.speed_noise
        P[2, 2] += numbers.turn_noise
    else:
        add_step_noise(speed * dt, theta, dt, numbers.var_speed, numbers.var_turn, P)
    symmetrise3(P)


@kernel
def correct_privately(
    belief: PoseBelief, home_fix: Float32[Array, "3"], variance: float, work: HomeUpdate
) -> None:
    """Correct an estimate by the fix at home, an unbiased reading of the whole pose.

        K = P (P + R)^-1,  R = variance I
        x = x + K (z - x)
        P = (I - K) P (I - K)' + K R K'

    `work.rest` is I - K afterwards.

    Source: BOIDS, Eq. 8 to 11.
    """
    pose, P = belief.pose, belief.P
    K, half, rest = work.gain, work.half, work.rest
    work.innovation = P
    for a in range(3):
        work.innovation[a, a] += variance
    inverse3(work.innovation, half)
    product3(P, half, K)
    residual = home_fix[0] - pose[0], home_fix[1] - pose[1], wrap(home_fix[2] - pose[2])
    for a in range(3):
        for k in range(3):
            pose[a] += K[a, k] * residual[k]
            rest[a, k] = (1.0 if a == k else 0.0) - K[a, k]
    pose[2] = wrap(pose[2])
    product3(rest, P, half)
    product3_transposed(half, rest, P)
    product3_transposed(K, K, half)
    for a in range(3):
        for b in range(3):
            P[a, b] += variance * half[a, b]
    symmetrise3(P)


@kernel
def visit_home(belief: PoseBelief, readings: Readings, work: HomeUpdate, numbers: Numbers) -> None:
    """Correct the estimate of a robot at home by the fix or, in the authors' code, reset it.

    Cross-covariances are unchanged.

    Source: BOIDS, authors' code, for the new start (0.1).
    """
    if not readings.at_home:
        return
    if numbers.authors > 0.0:
        identity3(START_VARIANCE, belief.P)
        for a in range(3):
            belief.pose[a] = readings.home_fix[a]
    else:
        correct_privately(belief, readings.home_fix, numbers.home_variance, work)


@kernel
def reckon(mind: PoseMind, readings: Readings, numbers: Numbers) -> None:
    """Update dead reckoning, which uses home and no neighbours, and copy the compass."""
    predict(mind.reckoned, readings.motion, numbers)
    visit_home(mind.reckoned, readings, mind.home, numbers)
    mind.compass = readings.compass


@kernel
def update_belief_alone(
    mind: PoseMind, shared: Array, readings: Readings, numbers: Numbers
) -> None:
    """Update an estimate by the robot's own readings, without cross-covariances."""
    reckon(mind, readings, numbers)
    predict(mind.belief, readings.motion, numbers)
    visit_home(mind.belief, readings, mind.home, numbers)
    mind.covariance_norm = spectral_norm3(mind.belief.P)
