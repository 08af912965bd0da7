"""The tick of the waypoints world: judge claims, move robots, measure, and update sightings."""

import math

from swarm_forage_env.arrays import Array
from swarm_forage_env.compiler import entry_point, kernel
from swarm_forage_env.equations.elementary import atan2, cos_sin, hypot
from swarm_forage_env.equations.geometry import range_and_bearing, wrap
from swarm_forage_env.equations.random_draws import Streams, normal, symmetric, unit
from swarm_forage_env.templates import row_template
from swarm_forage_env.ticks import Arrays, Errors
from swarm_forage_env.waypoints.records import (
    ENCODER,
    GOAL,
    LANDMARK,
    LIDAR,
    SPEED,
    TURN,
    RobotState,
    WorldState,
)


@kernel
def limited(speed: float, ahead: float, left: float, world: WorldState) -> tuple[float, float]:
    """Return speed [m/s] and turn rate [rad/s] of a tick for an acceleration (ahead, left).

        V = clip(V + a_max ahead dt, V_min, V_max)
        w = clip(atan2(left, ahead), -w_max, w_max)

    The turn rate is the angle times 1/s.

    Source: BOIDS, authors' code (the paper says only that accelerations steer).
    """
    target = speed + world.max_acceleration * ahead * world.dt
    turn = atan2(left, ahead) if ahead != 0.0 or left != 0.0 else 0.0
    fast = min(max(target, world.min_speed), world.max_speed)
    return fast, min(max(turn, -world.max_turn_rate), world.max_turn_rate)


@kernel
def turn_then_go(
    x: float, y: float, theta: float, speed: float, turn: float, dt: float
) -> tuple[float, float, float]:
    """Return the pose after a tick that first turns, then drives straight: x, y [m], theta [rad].

        theta += w dt
        x     += V dt cos(theta)
        y     += V dt sin(theta)

    Source: BOIDS, Eq. 5 as the authors' code has it.
    """
    after = wrap(theta + turn * dt)
    c, s = cos_sin(after)
    return x + speed * dt * c, y + speed * dt * s, after


@kernel
def drive(robot: RobotState, world: WorldState) -> None:
    """Move a robot by its command for a tick, and write its speed and turn rate to `motion`."""
    acceleration, pose, motion = robot.command.acceleration, robot.pose, robot.motion
    ahead, left = float(acceleration[0]), float(acceleration[1])
    motion[SPEED], motion[TURN] = limited(motion[SPEED], ahead, left, world)
    pose[0], pose[1], pose[2] = turn_then_go(
        pose[0], pose[1], pose[2], motion[SPEED], motion[TURN], world.dt
    )


@kernel
def judge_claim(robot: RobotState, world: WorldState) -> None:
    """Count a claim as right if the robot is at its goal, else as wrong; then draw a new goal."""
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
def place_at_home(robot: RobotState, world: WorldState, places: Streams, i: int) -> None:
    """Draw a uniform pose near home and a first goal in one quarter; set the full speed."""
    robot.pose[0] = world.start_half_side * symmetric(places, i)
    robot.pose[1] = world.start_half_side * symmetric(places, i)
    robot.pose[2] = math.pi * symmetric(places, i)
    for k in range(2):
        ahead = (world.half_side - world.first_goal) * unit(robot.streams, GOAL)
        robot.goal[k] = world.first_goal + ahead
    robot.motion[SPEED], robot.motion[TURN] = world.max_speed, 0.0


@kernel
def draw_devices(robot: RobotState, world: WorldState, devices: Streams, i: int) -> None:
    """Draw the noise and the constant error of the speed and turn rate readings of a robot."""
    for k in range(2):
        robot.deviation[k] = world.noise[k] * (1.0 + world.spread * symmetric(devices, i))
        robot.bias[k] = world.bias[k] * normal(devices, i)


@kernel
def measure_motion(robot: RobotState) -> None:
    """Measure speed and turn rate: true value, plus constant error of the robot, plus noise."""
    for k in range(2):
        noise = robot.deviation[k] * normal(robot.streams, ENCODER)
        robot.readings.motion[k] = robot.motion[k] + robot.bias[k] + noise


@kernel
def fix_at_home(robot: RobotState, world: WorldState) -> None:
    """Measure the pose if home, the origin, is within reach; write zeros otherwise."""
    readings, pose = robot.readings, robot.pose
    readings.at_home = hypot(pose[0], pose[1]) < world.reach
    for k in range(3):
        readings.home_fix[k] = 0.0
        if readings.at_home:
            readings.home_fix[k] = pose[k] + world.home_noise * normal(robot.streams, LANDMARK)


@kernel
def read_goal(robot: RobotState) -> None:
    """Write the readings of the compass and of the goal."""
    robot.readings.compass = robot.pose[2]
    for k in range(2):
        robot.readings.goal[k] = robot.goal[k]


@kernel
def see_each_other(swarm: Array, sightings: Array, world: WorldState) -> None:
    """Measure range and bearing between all robots; a robot measured within reach is seen.

    Robots farther than the reach plus eight standard deviations of the range are not measured.
    """
    farthest = world.reach + 8.0 * world.range_noise
    for i in range(swarm.shape[0]):
        pose, streams = swarm[i].pose, swarm[i].streams
        for j in range(swarm.shape[0]):
            sighting = sightings[i, j]
            sighting.seen, sighting.range, sighting.bearing = False, 0.0, 0.0
            dx, dy = swarm[j].pose[0] - pose[0], swarm[j].pose[1] - pose[1]
            if j == i or hypot(dx, dy) >= farthest:
                continue
            far, bearing = range_and_bearing(dx, dy, pose[2])
            far += world.range_noise * normal(streams, LIDAR)
            bearing = wrap(bearing + world.bearing_noise * normal(streams, LIDAR))
            if 0.0 < far < world.reach:
                sighting.seen, sighting.range, sighting.bearing = True, far, bearing


@row_template
def tick_world(world_arrays: Arrays, errors: Errors, w: int, n: int, n_moving: int) -> None:
    """Run one tick of the n robots of a world; if n_moving is 0, they only take first readings."""
    robots, sightings, worlds, rewards = world_arrays
    swarm, world = robots[w], worlds[w]
    if n_moving > 0:
        world.ticks += 1
    for i in range(n_moving):
        judge_claim(swarm[i], world)
        rewards[w, i] += swarm[i].reward
        drive(swarm[i], world)
        measure_motion(swarm[i])
        fix_at_home(swarm[i], world)
        read_goal(swarm[i])
    for i in range(n - n_moving):
        read_start(swarm[i])
        read_goal(swarm[i])
    if n > 0:
        see_each_other(swarm, sightings[w], world)


@entry_point
def judge_claims(robots: Array, worlds: Array) -> None:
    """Judge the claims of the robots of all worlds."""
    for w in range(robots.shape[0]):
        for i in range(robots.shape[1]):
            judge_claim(robots[w, i], worlds[w])


@entry_point
def start_at_home(robots: Array, worlds: Array, places: Array, devices: Array) -> None:
    """Draw start poses from `places` and sensor errors from `devices` for all robots."""
    for w in range(robots.shape[0]):
        for i in range(robots.shape[1]):
            place_at_home(robots[w, i], worlds[w], places[w], i)
            draw_devices(robots[w, i], worlds[w], devices[w], i)


@kernel
def read_start(robot: RobotState) -> None:
    """Write an exact home fix as the first reading of a robot."""
    robot.readings.at_home = True
    for k in range(3):
        robot.readings.home_fix[k] = robot.pose[k]
