"""Dead reckoning with a covariance: the prediction of every estimator of a pose.

Smith et al. 2021 (BOIDS), Section 2.1.
"""

import math

from baselines.estimators.matrices import Matrix3, product3, product3_transposed, symmetrise3
from swarm_forage_env.arrays import Array, Bool, Float32, Float64
from swarm_forage_env.kernels.compiler import kernel
from swarm_forage_env.kernels.frames import wrap

SPEED, TURN = 0, 1


@kernel
def step_jacobian(along: float, theta: float, out: Matrix3) -> None:
    """Derivative of the pose after a step by the pose before it.

        F = [1 0 -V dt sin(theta); 0 1 V dt cos(theta); 0 0 1]

    `along` = V dt [m]; theta is the heading after the turn [rad].

    Source: BOIDS, Eq. 2, whose robots turn before they go.
    """
    out[:, :] = 0.0
    out[0, 0] = out[1, 1] = out[2, 2] = 1.0
    out[0, 2] = -along * math.sin(theta)
    out[1, 2] = along * math.cos(theta)


@kernel
def add_step_noise(
    along: float, theta: float, dt: float, var_speed: float, var_turn: float, P: Matrix3
) -> None:
    """Add what errors of the measured speed and turn rate bring, in place.

        P = P + W diag(s_V^2, s_w^2) W'
        W = [ dt cos(theta)   -V dt^2 sin(theta)
              dt sin(theta)    V dt^2 cos(theta)
              0                dt ]

    Source: BOIDS, Eq. 2, differentiated by its inputs; the paper has no such matrix.
    """
    c, s = math.cos(theta), math.sin(theta)
    for k in range(2):
        variance = var_speed if k == 0 else var_turn
        x = dt * c if k == 0 else -along * dt * s
        y = dt * s if k == 0 else along * dt * c
        t = 0.0 if k == 0 else dt
        P[0, 0] += variance * x * x
        P[1, 1] += variance * y * y
        P[2, 2] += variance * t * t
        P[0, 1] += variance * x * y
        P[0, 2] += variance * x * t
        P[1, 2] += variance * y * t
    P[1, 0], P[2, 0], P[2, 1] = P[0, 1], P[0, 2], P[1, 2]


@kernel
def predict(
    measured: Float32[Array, "rows 2"],
    numbers: Array,
    scratch: Float64[Array, "2 3 3"],
    pose: Float64[Array, "rows 3"],
    P: Float64[Array, "rows 3 3"],
    velocity: Float64[Array, "rows 2"],
) -> None:
    """Move every estimate by what was measured, and let its covariance grow.

        x = f(x, u)
        P = F P F' + Q

    Q is `add_step_noise`, or, as the authors' code has it, diag(s_V, s_V, s_w): deviations in
    the place of variances, and no time step.

    Source: BOIDS, Eq. 2 and 6.
    """
    dt = numbers[0]["dt"]
    F, FP = scratch[0], scratch[1]
    for i in range(pose.shape[0]):
        speed, turn = float(measured[i, SPEED]), float(measured[i, TURN])
        theta = wrap(pose[i, 2] + turn * dt)
        velocity[i, 0], velocity[i, 1] = speed * math.cos(theta), speed * math.sin(theta)
        pose[i, 0] += velocity[i, 0] * dt
        pose[i, 1] += velocity[i, 1] * dt
        pose[i, 2] = theta
        step_jacobian(speed * dt, theta, F)
        product3(F, P[i], FP)
        product3_transposed(FP, F, P[i])
        if numbers[0]["authors"] > 0.0:
            P[i, 0, 0] += numbers[0]["speed_noise"]
            P[i, 1, 1] += numbers[0]["speed_noise"]
            P[i, 2, 2] += numbers[0]["turn_noise"]
        else:
            var_speed, var_turn = numbers[0]["var_speed"], numbers[0]["var_turn"]
            add_step_noise(speed * dt, theta, dt, var_speed, var_turn, P[i])
        symmetrise3(P[i])


@kernel
def carry_factors(
    measured: Float32[Array, "rows 2"],
    dt: float,
    pose: Float64[Array, "rows 3"],
    factors: Float64[Array, "rows robots 3 3"],
) -> None:
    """The factors of the cross-covariances after a step that led to `pose`, in place.

        s_ij = F s_ij

    Source: BOIDS, Eq. 7.
    """
    for i in range(pose.shape[0]):
        along = float(measured[i, SPEED]) * dt
        u, v = -along * math.sin(pose[i, 2]), along * math.cos(pose[i, 2])
        for j in range(factors.shape[1]):
            for k in range(3):
                factors[i, j, 0, k] += u * factors[i, j, 2, k]
                factors[i, j, 1, k] += v * factors[i, j, 2, k]


@kernel
def start_again(
    at_home: Bool[Array, " rows"],
    fix: Float32[Array, "rows 3"],
    variance: float,
    pose: Float64[Array, "rows 3"],
    P: Float64[Array, "rows 3 3"],
) -> None:
    """Those at home take its fix for their estimate, and start from P = variance I again.

    Source: BOIDS, authors' code (0.1); cross-covariances are left as they are.
    """
    for i in range(pose.shape[0]):
        if at_home[i]:
            for a in range(3):
                pose[i, a] = fix[i, a]
                for b in range(3):
                    P[i, a, b] = variance if a == b else 0.0
