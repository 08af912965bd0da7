"""Dynamics of the waypoints world: driving within limits, claiming goals, starting at home."""

import math

from swarm_forage_env.arrays import Array, UInt64
from swarm_forage_env.compiler import kernel
from swarm_forage_env.equations.elementary import atan2, cos_sin, hypot
from swarm_forage_env.equations.geometry import wrap
from swarm_forage_env.equations.random_draws import normal, symmetric, unit
from swarm_forage_env.waypoints.records import GOAL, SPEED, TURN, RobotState, WorldState


@kernel
def limited(speed: float, ahead: float, left: float, world: WorldState) -> tuple[float, float]:
    """Speed [m/s] and turn rate [rad/s] of a tick that an acceleration (ahead, left) asks for.

        V = clip(V + a_max ahead dt, V_min, V_max)
        w = clip(atan2(left, ahead), -w_max, w_max)

    The angle is taken times 1/s.

    Source: BOIDS, authors' code; the paper says only that accelerations steer.
    """
    asked = speed + world.max_acceleration * ahead * world.dt
    turn = atan2(left, ahead) if ahead != 0.0 or left != 0.0 else 0.0
    fast = min(max(asked, world.min_speed), world.max_speed)
    return fast, min(max(turn, -world.max_turn_rate), world.max_turn_rate)


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
    c, s = cos_sin(after)
    return x + speed * dt * c, y + speed * dt * s, after


@kernel
def drive(robot: RobotState, world: WorldState) -> None:
    """Move a robot for a tick as commanded; `motion` becomes its speed and turn rate."""
    acceleration, pose, motion = robot.command.acceleration, robot.pose, robot.motion
    ahead, left = float(acceleration[0]), float(acceleration[1])
    motion[SPEED], motion[TURN] = limited(motion[SPEED], ahead, left, world)
    pose[0], pose[1], pose[2] = turn_then_go(
        pose[0], pose[1], pose[2], motion[SPEED], motion[TURN], world.dt
    )


@kernel
def judge_claim(robot: RobotState, world: WorldState) -> None:
    """Book a claim as right, if the robot truly is at its goal, or wrong; a new goal then."""
    robot.reward = 0.0
    if not robot.command.claim:
        return
    pose, goal = robot.pose, robot.goal
    if hypot(pose[0] - goal[0], pose[1] - goal[1]) < world.tolerance:
        robot.right += 1
        robot.reward = 1.0
    else:
        robot.wrong += 1
    for k in range(2):
        goal[k] = world.half_side * symmetric(robot.streams, GOAL)


@kernel
def place_at_home(
    robot: RobotState, world: WorldState, places: UInt64[Array, " robots"], i: int
) -> None:
    """Uniform place about home and heading, full speed, and a first goal in one quarter."""
    robot.pose[0] = world.start_half_side * symmetric(places, i)
    robot.pose[1] = world.start_half_side * symmetric(places, i)
    robot.pose[2] = math.pi * symmetric(places, i)
    for k in range(2):
        ahead = (world.half_side - world.first_goal) * unit(robot.streams, GOAL)
        robot.goal[k] = world.first_goal + ahead
    robot.motion[SPEED], robot.motion[TURN] = world.max_speed, 0.0


@kernel
def draw_devices(
    robot: RobotState, world: WorldState, devices: UInt64[Array, " robots"], i: int
) -> None:
    """Draw the robot's own noise and constant error of the readings of speed and turn rate."""
    for k in range(2):
        robot.deviation[k] = world.noise[k] * (1.0 + world.spread * symmetric(devices, i))
        robot.bias[k] = world.bias[k] * normal(devices, i)
