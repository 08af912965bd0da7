"""The tick of the foraging world: everyone moves, is scored, senses and hears."""

import math

from swarm_forage_env.arrays import Array, Float64, Int32
from swarm_forage_env.compiler import entry_point, inlined, kernel
from swarm_forage_env.equations.differential_drive import advance, wheels_to_arc
from swarm_forage_env.foraging.fault_effects import update_faults
from swarm_forage_env.foraging.fault_record import DEAD
from swarm_forage_env.foraging.floor import move_areas
from swarm_forage_env.foraging.obstacle_contacts import resolve_contacts_among
from swarm_forage_env.foraging.obstacle_sensing import cast_rays_at_obstacles, put_shadowed_last
from swarm_forage_env.foraging.records import RobotState, WorldState
from swarm_forage_env.foraging.scoring import count_reports, score
from swarm_forage_env.foraging.sensors import (
    listen,
    read_encoders,
    read_ground,
    read_proximity,
)
from swarm_forage_env.foraging.surroundings import COUNT, find_neighbours, resolve_contacts


@kernel
def set_wheels(robot: RobotState, world: WorldState) -> None:
    """Turn the wheels as commanded, as far as the motors go [m/s]; those of a dead robot stand."""
    if robot.fault.active[DEAD]:
        robot.wheels[0] = robot.wheels[1] = 0.0
        return
    for side in range(2):
        speed = float(robot.command.wheels[side]) * world.cruise_speed
        robot.wheels[side] = min(max(speed, -world.max_speed), world.max_speed)


@kernel
def drive(robot: RobotState, world: WorldState) -> None:
    """Move a robot for a tick as its wheels turn."""
    dU_l, dU_r = robot.wheels[0] * world.dt, robot.wheels[1] * world.dt
    if dU_l != 0.0 or dU_r != 0.0:
        drho, dtheta = wheels_to_arc(dU_l, dU_r, world.axle)
        pose = robot.pose
        pose[0], pose[1], pose[2] = advance(pose[0], pose[1], pose[2], drho, dtheta)


@kernel
def face(robot: RobotState) -> None:
    """Keep cosine and sine of the heading beside it."""
    robot.heading[0], robot.heading[1] = math.cos(robot.pose[2]), math.sin(robot.pose[2])


@kernel
def update_all_faults(swarm: Array, world: WorldState) -> None:
    """Let the faults of all robots of a world begin whose time has come."""
    for i in range(swarm.shape[0]):
        update_faults(swarm[i], world)


@entry_point
def tick(  # noqa: PLR0913 a block of worlds, its tables, and which of them
    robots: Array,
    worlds: Array,
    near: Int32[Array, "worlds robots columns"],
    cells: Int32[Array, "worlds cells"],
    obstacles: Float64[Array, "worlds obstacles 5"],
    first: int,
    last: int,
) -> int:
    """One tick of the worlds first .. last - 1; the most neighbours that any robot has."""
    most = 0
    for w in range(first, last):
        world, swarm = worlds[w], robots[w]
        standing = obstacles[w, : world.n_obstacles]
        world.ticks += 1
        move_areas(world)
        if not world.has_moved:
            for i in range(swarm.shape[0]):
                set_wheels(swarm[i], world)
                drive(swarm[i], world)
        world.has_moved = False
        most = max(most, find_neighbours(swarm, near[w], cells[w], world))
        if world.n_obstacles == 0:
            resolve_contacts(swarm, near[w], world)
        else:
            resolve_contacts_among(swarm, near[w], world, standing)
        for i in range(swarm.shape[0]):
            face(swarm[i])
            score(swarm[i], world)
            count_reports(swarm[i], world)
        if world.has_faults:
            update_all_faults(swarm, world)
        for i in range(swarm.shape[0]):
            sense(swarm, i, near[w], world, standing)
            hear(swarm, i, near[w], world, standing)
    return most


@entry_point
def sense_first(  # noqa: PLR0913 a block of worlds, its tables, and which of them
    robots: Array,
    worlds: Array,
    near: Int32[Array, "worlds robots columns"],
    cells: Int32[Array, "worlds cells"],
    obstacles: Float64[Array, "worlds obstacles 5"],
    first: int,
    last: int,
) -> int:
    """What is sensed before the first tick, when nobody has spoken yet."""
    most = 0
    for w in range(first, last):
        world, swarm = worlds[w], robots[w]
        standing = obstacles[w, : world.n_obstacles]
        most = max(most, find_neighbours(swarm, near[w], cells[w], world))
        for i in range(swarm.shape[0]):
            face(swarm[i])
            swarm[i].heard.n = 0
        if world.has_faults:
            update_all_faults(swarm, world)
        for i in range(swarm.shape[0]):
            sense(swarm, i, near[w], world, standing)
    return most


@inlined
def sense(
    swarm: Array,
    i: int,
    near: Int32[Array, "robots columns"],
    world: WorldState,
    obstacles: Float64[Array, "obstacles 5"],
) -> None:
    """Read all sensors of robot i but the radio."""
    if obstacles.shape[0] > 0:
        cast_rays_at_obstacles(swarm[i], world, obstacles)
    read_encoders(swarm[i], world)
    read_ground(swarm[i], world)
    read_proximity(swarm, i, near, world)


@inlined
def hear(
    swarm: Array,
    i: int,
    near: Int32[Array, "robots columns"],
    world: WorldState,
    obstacles: Float64[Array, "obstacles 5"],
) -> None:
    """Deliver the messages to robot i: a shadowed radio, from those whom no obstacle hides."""
    n_near = near[i, COUNT]
    if world.is_shadowed:
        near[i, COUNT] = put_shadowed_last(swarm, i, near, obstacles)
    listen(swarm, i, near, world)
    near[i, COUNT] = n_near
