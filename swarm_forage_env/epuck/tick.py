"""Tick of a world of e-pucks: robots move, are scored, sense and receive messages.

A task binds four free names:

- `begin_world(world)` and `begin_tick(world)`: changes of the world at its start, and in each tick
  before robots move;
- `brightness_at(x, y, world)`: brightness of the floor, from 0 (black) to 1 (white);
- `score(swarm, i, world)`: writes the reward of robot i. Robots are scored in parallel: it may read
  all of `swarm` that no score writes, and must write to robot i only.
"""

from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.compiler import inlined, kernel
from swarm_forage_env.epuck.contacts import resolve_contacts
from swarm_forage_env.epuck.fault_draws import update_faults
from swarm_forage_env.epuck.fault_record import DEAD, DEAF
from swarm_forage_env.epuck.records import EpuckState, EpuckWorldState
from swarm_forage_env.epuck.sensors import (
    cast_rays_at_obstacles,
    keep_slots,
    read_encoders,
    read_ground,
    read_proximity,
    receive_messages,
    sort_shadowed_last,
)
from swarm_forage_env.epuck.surroundings import COUNT, FIRST, Neighbours
from swarm_forage_env.equations.contacts import keep_inside
from swarm_forage_env.equations.differential_drive import advance, wheels_to_arc
from swarm_forage_env.equations.elementary import cos_sin
from swarm_forage_env.equations.obstacles import Capsules
from swarm_forage_env.interface import Kernel
from swarm_forage_env.templates import row_template
from swarm_forage_env.ticks import TOO_MANY_NEAR, Arrays, Errors, note

lane: Kernel
lanes: Kernel
barrier: Kernel
list_neighbours: Kernel
begin_world: Kernel
begin_tick: Kernel
score: Kernel
"""Free names of the templates: lanes, the listing of neighbours, and functions of the task."""


@kernel
def set_wheels(robot: EpuckState, world: EpuckWorldState) -> None:
    """Set the wheel speeds [m/s] to the command, within the motor limits; 0 for a dead robot."""
    if robot.is_faulty[DEAD]:
        robot.wheels[0] = robot.wheels[1] = 0.0
        return
    for side in range(2):
        speed = float(robot.command.wheels[side]) * world.cruise_speed
        robot.wheels[side] = min(max(speed, -world.max_speed), world.max_speed)


@kernel
def drive(robot: EpuckState, world: EpuckWorldState) -> None:
    """Move a robot by the path of its wheels in a tick."""
    dU_l, dU_r = robot.wheels[0] * world.dt, robot.wheels[1] * world.dt
    if dU_l != 0.0 or dU_r != 0.0:
        drho, dtheta = wheels_to_arc(dU_l, dU_r, world.axle)
        pose = robot.pose
        pose[0], pose[1], pose[2] = advance(pose[0], pose[1], pose[2], drho, dtheta)


@kernel
def is_overlapping(swarm: Array, i: int, near: Neighbours, world: EpuckWorldState) -> bool:
    """Return whether robot i may overlap a neighbour with a lower index."""
    apart = 2.0 * world.radius * 1.000001
    for k in range(FIRST, FIRST + near[i, COUNT]):
        j = near[i, k]
        if j > i:
            break
        dx, dy = swarm[j].pose[0] - swarm[i].pose[0], swarm[j].pose[1] - swarm[i].pose[1]
        if dx * dx + dy * dy < apart * apart:
            return True
    return False


@row_template
def keep_apart(
    swarm: Array, near: Neighbours, world: EpuckWorldState, obstacles: Capsules, n_robots: int
) -> None:
    """Keep robots inside the walls, apart from each other and out of obstacles.

    The first lane resolves the contacts, one after the other, and only in a world in which robots
    overlap or that has obstacles.
    """
    leads = n_robots > 0 and lane() == 0
    if leads:
        world.is_crowded = world.n_obstacles > 0
    for i in range(lane(), n_robots, lanes()):
        keep_inside(swarm[i].pose, world.arena, world.radius)
    barrier()
    for i in range(lane(), n_robots, lanes()):
        if is_overlapping(swarm, i, near, world):
            world.is_crowded = True
    barrier()
    if leads and world.is_crowded:
        resolve_contacts(swarm, near, world, obstacles)
    if leads:
        world.is_crowded = False
    barrier()


@row_template
def move_all(swarm: Array, world: EpuckWorldState, n: int, n_moving: int) -> None:
    """Begin a tick: run the task's functions, and drive robots unless an engine moved them."""
    leads = n > 0 and lane() == 0
    if leads and n_moving == 0:
        begin_world(world)
    elif leads:
        world.ticks += 1
        begin_tick(world)
    if not world.has_moved:
        for i in range(lane(), n_moving, lanes()):
            set_wheels(swarm[i], world)
            drive(swarm[i], world)
    barrier()
    if leads and n_moving > 0:
        world.has_moved = False


@row_template
def score_all(
    swarm: Array,
    faults: Array,
    world: EpuckWorldState,
    rewards: Float64[Array, " robots"],
    n: int,
    n_moving: int,
) -> None:
    """Score the robots that moved; in a world that begins, clear their message counts."""
    for i in range(lane(), n, lanes()):
        swarm[i].heading[0], swarm[i].heading[1] = cos_sin(swarm[i].pose[2])
    barrier()
    for i in range(lane(), n, lanes()):
        robot = swarm[i]
        if n_moving > 0:
            score(swarm, i, world)
            rewards[i] += robot.reward
        else:
            robot.heard.n = 0
        if world.has_faults:
            update_faults(robot, faults[i], world)


@row_template
def tick_world(world_arrays: Arrays, errors: Errors, w: int, n: int, n_moving: int) -> None:
    """Run one tick of the n robots of a world: they move, are scored, sense and receive messages.

    In a world that begins (`n_moving` is 0) robots only sense.
    """
    robots, worlds, near, cells, obstacles, rewards, all_faults = world_arrays[:7]
    swarm, faults, world = robots[w], all_faults[w], worlds[w]
    standing = obstacles[w, : world.n_obstacles]
    move_all(swarm, world, n, n_moving)
    most = list_neighbours(swarm, near[w], cells[w], world, n)
    if most > near.shape[2] - FIRST:
        note(errors, w, TOO_MANY_NEAR, most)
    barrier()
    keep_apart(swarm, near[w], world, standing, n_moving)
    score_all(swarm, faults, world, rewards[w], n, n_moving)
    barrier()
    for i in range(lane(), n, lanes()):
        if world.n_obstacles > 0:
            cast_rays_at_obstacles(swarm[i], world, standing)
        read_encoders(swarm[i], faults[i], world)
        read_ground(swarm[i], world)
        read_proximity(swarm, i, near[w], world)
        if n_moving > 0:
            hear(swarm, i, near[w], world, standing)


@inlined
def hear(
    swarm: Array, i: int, near: Neighbours, world: EpuckWorldState, obstacles: Capsules
) -> None:
    """Deliver messages to robot i unless it is deaf; a shadowed radio hears none past obstacles."""
    if swarm[i].is_faulty[DEAF]:
        keep_slots(swarm[i].heard, 0)
        return
    n_near = near[i, COUNT]
    if world.is_shadowed:
        near[i, COUNT] = sort_shadowed_last(swarm, i, near, obstacles)
    receive_messages(swarm, i, near, world)
    near[i, COUNT] = n_near
