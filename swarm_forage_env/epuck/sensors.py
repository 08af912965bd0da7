"""Sensors of the e-puck: noisy readings of one robot from the ground truth."""

import math

from swarm_forage_env.arrays import Array
from swarm_forage_env.compiler import kernel
from swarm_forage_env.epuck.contacts import is_near_walls
from swarm_forage_env.epuck.fault_record import BLIND, WORN, Fault
from swarm_forage_env.epuck.records import (
    ENCODER,
    GROUND,
    LOSS,
    PROXIMITY,
    RADIO,
    SLOT,
    EpuckState,
    EpuckWorldState,
    Heard,
)
from swarm_forage_env.epuck.surroundings import COUNT, FIRST, Neighbours
from swarm_forage_env.equations.differential_drive import encoder, wheels_to_arc
from swarm_forage_env.equations.elementary import atan2, hypot
from swarm_forage_env.equations.geometry import range_and_bearing, to_body, to_outer, wrap
from swarm_forage_env.equations.obstacles import (
    Capsule,
    Capsules,
    from_axis,
    is_between,
    ray_to_capsule,
)
from swarm_forage_env.equations.proximity import (
    RAY_COS,
    RAY_SIN,
    SENSING_RANGE,
    ray_to_disc,
    ray_to_walls,
    response,
)
from swarm_forage_env.equations.radio import loss, mean_board_range, mean_error
from swarm_forage_env.equations.random_draws import below, symmetric, unit
from swarm_forage_env.interface import Kernel
from swarm_forage_env.templates import row_template

brightness_at: Kernel
"""Free name of the row template: the brightness of the task's floor."""


@kernel
def read_encoders(robot: EpuckState, fault: Fault, world: EpuckWorldState) -> None:
    """Write the distance [m] and turn [rad] of the tick, from noisy encoders.

    Pushed or blocked robots read the turning of their wheels only; worn ones misread it.
    """
    dU_l, dU_r, error = robot.wheels[0] * world.dt, robot.wheels[1] * world.dt, world.encoder_error
    if robot.is_faulty[WORN]:
        dU_l, dU_r = dU_l * fault.path_misread[0], dU_r * fault.path_misread[1]
        error *= world.faults.noise_factor
    dU_l = encoder(dU_l, error, robot.streams, ENCODER)
    dU_r = encoder(dU_r, error, robot.streams, ENCODER)
    distance, turn = wheels_to_arc(dU_l, dU_r, world.axle)
    robot.readings.odometry[0], robot.readings.odometry[1] = distance, turn


@row_template
def read_ground(robot: EpuckState, world: EpuckWorldState) -> None:
    """Write the brightness times 1 +- noise under the left, middle and right sensor."""
    c, s = robot.heading[0], robot.heading[1]
    for sensor in range(3):
        dx, dy = to_outer(world.ground_ahead, (1 - sensor) * world.ground_spacing, c, s)
        light = brightness_at(robot.pose[0] + dx, robot.pose[1] + dy, world)
        if light > 0.0:
            light *= 1.0 + world.ground_noise * symmetric(robot.streams, GROUND)
        robot.readings.ground[sensor] = light


@kernel
def shorten_rays_at_walls(robot: EpuckState, world: EpuckWorldState) -> None:
    """Shorten every infrared ray of a robot at the outer walls of the arena."""
    x, y, c, s = robot.pose[0], robot.pose[1], robot.heading[0], robot.heading[1]
    for ray in range(8):
        u = c * RAY_COS[ray] - s * RAY_SIN[ray]
        v = s * RAY_COS[ray] + c * RAY_SIN[ray]
        robot.rays[ray] = min(robot.rays[ray], ray_to_walls(x, y, u, v, world.arena, world.radius))


@kernel
def cast_rays_at_obstacles(robot: EpuckState, world: EpuckWorldState, obstacles: Capsules) -> None:
    """Set the infrared rays of a robot to their lengths up to the obstacles, else infinity."""
    robot.rays[:] = math.inf
    for k in range(obstacles.shape[0]):
        dx, dy = from_axis(robot.pose[0], robot.pose[1], obstacles[k])
        if hypot(dx, dy) < world.radius + SENSING_RANGE + obstacles[k, 4]:
            shorten_rays_at_obstacle(robot, world, obstacles[k])


@kernel
def shorten_rays_at_obstacle(robot: EpuckState, world: EpuckWorldState, capsule: Capsule) -> None:
    """Shorten the infrared rays of a robot that hit a capsule."""
    x, y, c, s = robot.pose[0], robot.pose[1], robot.heading[0], robot.heading[1]
    for ray in range(8):
        u = c * RAY_COS[ray] - s * RAY_SIN[ray]
        v = s * RAY_COS[ray] + c * RAY_SIN[ray]
        d = max(ray_to_capsule(x, y, u, v, capsule) - world.radius, 0.0)
        robot.rays[ray] = min(robot.rays[ray], d)


@kernel
def cast_rays(swarm: Array, i: int, near: Neighbours, world: EpuckWorldState) -> bool:
    """Write the length of each infrared ray of robot i; return false if nothing is in range.

    If there are obstacles, the rays must already end at them.
    """
    robot, reach = swarm[i], 2.0 * world.radius + SENSING_RANGE
    is_any_near = world.n_obstacles > 0
    if is_near_walls(robot, world, SENSING_RANGE):
        if not is_any_near:
            robot.rays[:] = math.inf
            is_any_near = True
        shorten_rays_at_walls(robot, world)
    for k in range(FIRST, FIRST + near[i, COUNT]):
        other = swarm[near[i, k]]
        dx, dy = other.pose[0] - robot.pose[0], other.pose[1] - robot.pose[1]
        if dx * dx + dy * dy < reach * reach:
            if not is_any_near:
                robot.rays[:] = math.inf
                is_any_near = True
            ahead, left = to_body(dx, dy, robot.heading[0], robot.heading[1])
            for ray in range(8):
                way = ray_to_disc(ahead, left, ray, world.radius)
                robot.rays[ray] = min(robot.rays[ray], way)
    return is_any_near


@kernel
def read_proximity(swarm: Array, i: int, near: Neighbours, world: EpuckWorldState) -> None:
    """Write the responses of the infrared sensors times 1 +- noise, at most 1; 0 if it is blind."""
    robot = swarm[i]
    if not cast_rays(swarm, i, near, world) or robot.is_faulty[BLIND]:
        robot.readings.proximity[:] = 0.0
        return
    for ray in range(8):
        reading = response(robot.rays[ray])
        if reading > 0.0:
            noise = world.proximity_noise * symmetric(robot.streams, PROXIMITY)
            reading = min(reading * (1.0 + noise), 1.0)
        robot.readings.proximity[ray] = reading


@kernel
def is_shadowed(robot: EpuckState, sender: EpuckState, obstacles: Capsules) -> bool:
    """Return whether an obstacle is between the centres of two robots."""
    here, there = robot.pose, sender.pose
    for k in range(obstacles.shape[0]):
        if is_between(here[0], here[1], there[0], there[1], obstacles[k]):
            return True
    return False


@kernel
def sort_shadowed_last(swarm: Array, i: int, near: Neighbours, obstacles: Capsules) -> int:
    """Move the neighbours of robot i that are hidden by obstacles to the end of its row.

    Returns the number of the other neighbours, which are not kept in order.
    """
    n_open = near[i, COUNT]
    k = 0
    while k < n_open:
        at, last = FIRST + k, FIRST + n_open - 1
        if is_shadowed(swarm[i], swarm[near[i, at]], obstacles):
            near[i, at], near[i, last] = near[i, last], near[i, at]
            n_open -= 1
        else:
            k += 1
    return int(n_open)


@kernel
def keep_slots(heard: Heard, n: int) -> None:
    """Keep the first n message slots, and clear the other slots in use."""
    for slot in range(n, heard.n):
        heard.is_valid[slot] = heard.n_averaged[slot] = 0.0
        for k in range(3):
            heard.range_bearing[slot, k] = 0.0
    heard.n = n


@kernel
def receive_messages(swarm: Array, i: int, near: Neighbours, world: EpuckWorldState) -> None:
    """Write the messages that robot i receives, with measured range and bearings.

    If more messages arrive than there are slots, each is equally likely (reservoir sampling).
    """
    robot, arrived = swarm[i], 0
    for k in range(FIRST, FIRST + near[i, COUNT]):
        sender = swarm[near[i, k]]
        if not sender.command.is_speaking or sender.is_silent:
            continue
        d = hypot(sender.pose[0] - robot.pose[0], sender.pose[1] - robot.pose[1])
        if d > world.max_range:
            continue
        lost = loss(d, world.full_reception_range, world.max_range, world.loss_near, world.loss_far)
        if unit(robot.streams, LOSS) < lost:
            continue
        slot = arrived
        if slot >= world.slots:
            slot = below(robot.streams, SLOT, arrived + 1)
        arrived += 1
        if slot < world.slots:
            robot.heard.sender[slot] = near[i, k]
    keep_slots(robot.heard, min(arrived, world.slots))
    robot.messages += robot.heard.n
    for slot in range(robot.heard.n):
        measure_range_bearing(robot, swarm[robot.heard.sender[slot]], slot, world)


@kernel
def measure_range_bearing(
    robot: EpuckState, sender: EpuckState, slot: int, world: EpuckWorldState
) -> None:
    """Write range [m], bearing and bearing back [rad] of the sender in a slot, with noise.

    A receiver at rest averages several frames, a moving one uses a single frame.
    """
    is_at_rest = robot.wheels[0] == 0.0 and robot.wheels[1] == 0.0
    frames = world.frames if is_at_rest else 1
    dx, dy = sender.pose[0] - robot.pose[0], sender.pose[1] - robot.pose[1]
    d, bearing = range_and_bearing(dx, dy, robot.pose[2])
    back = wrap(atan2(-dy, -dx) - sender.pose[2])
    measured = robot.heard.range_bearing
    if world.is_board:
        gap = max(d - 2.0 * world.radius, 0.0)
        gap = mean_board_range(gap, robot.streams, RADIO, frames)
        measured[slot, 0] = 2.0 * world.radius + gap
    else:
        error = mean_error(robot.streams, RADIO, frames, world.range_noise)
        measured[slot, 0] = max(d + error, 0.0)
    noise = world.bearing_noise
    measured[slot, 1] = wrap(bearing + mean_error(robot.streams, RADIO, frames, noise))
    measured[slot, 2] = wrap(back + mean_error(robot.streams, RADIO, frames, noise))
    robot.heard.n_averaged[slot], robot.heard.is_valid[slot] = frames, 1.0
