"""Kernels of the waypoints world: driving within limits, seeing each other, claiming goals."""

import math

from swarm_forage_env.arrays import Array, Bool, Float32, Float64, Int32, UInt64
from swarm_forage_env.compiler import kernel
from swarm_forage_env.equations.geometry import range_and_bearing, wrap
from swarm_forage_env.equations.random_draws import normal, symmetric, unit

SPEED, TURN = 0, 1
"""Columns of what is measured and commanded of a robot's motion."""


@kernel
def limited(
    speed: float, ahead: float, left: float, limits: Array, dt: float
) -> tuple[float, float]:
    """Speed [m/s] and turn rate [rad/s] of a tick that a pull (ahead, left) asks for.

        V = clip(V + a_max ahead dt, V_min, V_max)
        w = clip(atan2(left, ahead), -w_max, w_max)   [1/s times the angle]

    Source: BOIDS, authors' code; the paper says only that accelerations steer.
    """
    asked = speed + limits[0]["max_acceleration"] * ahead * dt
    turn = math.atan2(left, ahead) if ahead != 0.0 or left != 0.0 else 0.0
    most = limits[0]["max_turn_rate"]
    fast = min(max(asked, limits[0]["min_speed"]), limits[0]["max_speed"])
    return fast, min(max(turn, -most), most)


@kernel
def turn_then_go(
    x: float, y: float, theta: float, speed: float, turn: float, dt: float
) -> tuple[float, float, float]:
    """The pose after a tick that turns first and then goes straight: x, y [m], theta [rad].

        theta += w dt
        x     += V dt cos(theta)
        y     += V dt sin(theta)

    Source: BOIDS, Eq. 2 as the authors' code has it.
    """
    after = wrap(theta + turn * dt)
    return x + speed * dt * math.cos(after), y + speed * dt * math.sin(after), after


@kernel
def drive_within_limits(
    pull: Float32[Array, "rows 2"],
    limits: Array,
    dt: float,
    pose: Float64[Array, "rows 3"],
    motion: Float64[Array, "rows 2"],
) -> None:
    """Move every robot for a tick, in place; `motion` becomes its speed and turn rate."""
    for i in range(pose.shape[0]):
        speed, turn = limited(motion[i, SPEED], float(pull[i, 0]), float(pull[i, 1]), limits, dt)
        pose[i, 0], pose[i, 1], pose[i, 2] = turn_then_go(
            pose[i, 0], pose[i, 1], pose[i, 2], speed, turn, dt
        )
        motion[i, SPEED], motion[i, TURN] = speed, turn


@kernel
def measure_motion(
    motion: Float64[Array, "rows 2"],
    deviation: Float64[Array, "rows 2"],
    bias: Float64[Array, "rows 2"],
    streams: UInt64[Array, " rows"],
    out_motion: Float32[Array, "rows 2"],
) -> None:
    """What wheels and gyro say: truth, a constant error of the robot's own, and noise."""
    for i in range(motion.shape[0]):
        for k in range(2):
            noise = deviation[i, k] * normal(streams, i)
            out_motion[i, k] = motion[i, k] + bias[i, k] + noise


@kernel
def fix_at_home(
    pose: Float64[Array, "rows 3"],
    reach: float,
    noise: float,
    streams: UInt64[Array, " rows"],
    out_at_home: Bool[Array, " rows"],
    out_fix: Float32[Array, "rows 3"],
) -> None:
    """The pose as home, the origin, tells it to those within reach [m]."""
    for i in range(pose.shape[0]):
        out_at_home[i] = math.hypot(pose[i, 0], pose[i, 1]) < reach
        for k in range(3):
            out_fix[i, k] = pose[i, k] + noise * normal(streams, i) if out_at_home[i] else 0.0


@kernel
def see_each_other(  # noqa: PLR0913 inputs first, then the outputs
    pose: Float64[Array, "rows 3"],
    n_robots: int,
    reach: float,
    range_noise: float,
    bearing_noise: float,
    streams: UInt64[Array, " rows"],
    out_seen: Bool[Array, "rows robots"],
    out_range: Float32[Array, "rows robots"],
    out_bearing: Float32[Array, "rows robots"],
) -> None:
    """Range and bearing from every robot to those of its world that it measures within reach.

    Nobody beyond the reach by eight standard deviations of the range is measured at all.
    """
    farthest = reach + 8.0 * range_noise
    for i in range(pose.shape[0]):
        first = i // n_robots * n_robots
        for other in range(n_robots):
            j = first + other
            out_seen[i, other] = False
            out_range[i, other] = 0.0
            out_bearing[i, other] = 0.0
            dx, dy = pose[j, 0] - pose[i, 0], pose[j, 1] - pose[i, 1]
            if j == i or math.hypot(dx, dy) >= farthest:
                continue
            far, bearing = range_and_bearing(dx, dy, pose[i, 2])
            far += range_noise * normal(streams, i)
            bearing = wrap(bearing + bearing_noise * normal(streams, i))
            if 0.0 < far < reach:
                out_seen[i, other] = True
                out_range[i, other] = far
                out_bearing[i, other] = bearing


@kernel
def judge_claims(  # noqa: PLR0913 inputs first, then what is updated
    claim: Bool[Array, " rows"],
    pose: Float64[Array, "rows 3"],
    tolerance: float,
    half_side: float,
    streams: UInt64[Array, " rows"],
    goal: Float64[Array, "rows 2"],
    right: Int32[Array, " rows"],
    wrong: Int32[Array, " rows"],
    out_reward: Float32[Array, " rows"],
) -> None:
    """Book every claim as right, if the robot truly is at its goal, or wrong; a new goal then."""
    for i in range(pose.shape[0]):
        out_reward[i] = 0.0
        if not claim[i]:
            continue
        if math.hypot(pose[i, 0] - goal[i, 0], pose[i, 1] - goal[i, 1]) < tolerance:
            right[i] += 1
            out_reward[i] = 1.0
        else:
            wrong[i] += 1
        for k in range(2):
            goal[i, k] = half_side * symmetric(streams, i)


@kernel
def place_at_home(  # noqa: PLR0913 inputs first, then the outputs
    half_side: float,
    first_goal: float,
    goal_half_side: float,
    places: UInt64[Array, " robots"],
    goals: UInt64[Array, " robots"],
    out_pose: Float64[Array, "robots 3"],
    out_goal: Float64[Array, "robots 2"],
) -> None:
    """Uniform places about home, headings, and first goals."""
    for i in range(out_pose.shape[0]):
        out_pose[i, 0] = half_side * symmetric(places, i)
        out_pose[i, 1] = half_side * symmetric(places, i)
        out_pose[i, 2] = math.pi * symmetric(places, i)
        for k in range(2):
            out_goal[i, k] = first_goal + (goal_half_side - first_goal) * unit(goals, i)


@kernel
def draw_devices(
    noise: Float64[Array, "2"],
    bias: Float64[Array, "2"],
    spread: float,
    streams: UInt64[Array, " robots"],
    out_deviation: Float64[Array, "robots 2"],
    out_bias: Float64[Array, "robots 2"],
) -> None:
    """Each robot's own noise and constant error of speed and turn rate."""
    for i in range(out_bias.shape[0]):
        for k in range(2):
            out_deviation[i, k] = noise[k] * (1.0 + spread * symmetric(streams, i))
            out_bias[i, k] = bias[k] * normal(streams, i)
