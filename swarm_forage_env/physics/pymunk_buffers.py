"""Between the records of robots and the buffers of pymunk: x, y, angle, vx, vy, spin."""

import math

from swarm_forage_env.arrays import Array, Bool, Float64, Int32
from swarm_forage_env.compiler import entry_point, kernel
from swarm_forage_env.equations.differential_drive import wheels_to_arc
from swarm_forage_env.equations.geometry import wrap
from swarm_forage_env.equations.obstacles import from_axis
from swarm_forage_env.foraging.records import RobotState, WorldState
from swarm_forage_env.foraging.surroundings import COUNT, FIRST
from swarm_forage_env.foraging.tick import set_wheels


@kernel
def path_of(robot: RobotState, dt: float) -> float:
    """How far the centre of a robot goes in dt [s] at its wheel speeds [m]."""
    return float(0.5 * abs(robot.wheels[0] + robot.wheels[1]) * dt)


@kernel
def may_touch_wall(robot: RobotState, world: WorldState) -> bool:
    """The body can reach a wall within the tick."""
    far = world.radius + path_of(robot, world.dt)
    x, y = abs(robot.pose[0]), abs(robot.pose[1])
    return bool(x >= 0.5 * world.arena[0] - far or y >= 0.5 * world.arena[1] - far)


@kernel
def may_touch_obstacle(
    robot: RobotState, world: WorldState, obstacles: Float64[Array, "obstacles 5"]
) -> bool:
    """The body can reach an obstacle within the tick."""
    far = world.radius + path_of(robot, world.dt)
    for k in range(obstacles.shape[0]):
        dx, dy = from_axis(robot.pose[0], robot.pose[1], obstacles[k])
        if math.hypot(dx, dy) <= far + obstacles[k, 4]:
            return True
    return False


@kernel
def may_touch(
    swarm: Array,
    near: Int32[Array, "robots columns"],
    world: WorldState,
    obstacles: Float64[Array, "obstacles 5"],
) -> bool:
    """A body of the world can reach another, a wall or an obstacle within the tick.

    `near` lists the neighbours before the tick.
    """
    for i in range(swarm.shape[0]):
        robot = swarm[i]
        if may_touch_wall(robot, world) or may_touch_obstacle(robot, world, obstacles):
            return True
        for k in range(FIRST, FIRST + near[i, COUNT]):
            other = swarm[near[i, k]]
            paths = path_of(robot, world.dt) + path_of(other, world.dt)
            dx, dy = other.pose[0] - robot.pose[0], other.pose[1] - robot.pose[1]
            if math.hypot(dx, dy) <= 2.0 * world.radius + paths:
                return True
    return False


@kernel
def write_body(robot: RobotState, world: WorldState, out_body: Float64[Array, "6"]) -> None:
    """The pose, and the velocity that carries the robot along the chord of its arc in a tick."""
    speed, spin = wheels_to_arc(robot.wheels[0], robot.wheels[1], world.axle)
    middle = robot.pose[2] + 0.5 * spin * world.dt
    out_body[0], out_body[1], out_body[2] = robot.pose[0], robot.pose[1], robot.pose[2]
    out_body[3] = speed * math.cos(middle)
    out_body[4] = speed * math.sin(middle)
    out_body[5] = spin


@entry_point
def write_bodies(  # noqa: PLR0913 a block of worlds, its buffers, and which of them
    robots: Array,
    worlds: Array,
    near: Int32[Array, "worlds robots columns"],
    obstacles: Float64[Array, "worlds obstacles 5"],
    first: int,
    last: int,
    out_bodies: Float64[Array, "worlds bodies 6"],
    out_touching: Bool[Array, " worlds"],
) -> None:
    """Turn the wheels; write the bodies of the worlds in which they may touch, and which these are.

    Only worlds first .. last - 1.
    """
    for w in range(first, last):
        world, swarm = worlds[w], robots[w]
        for i in range(swarm.shape[0]):
            set_wheels(swarm[i], world)
        out_touching[w] = may_touch(swarm, near[w], world, obstacles[w, : world.n_obstacles])
        if out_touching[w]:
            for i in range(swarm.shape[0]):
                write_body(swarm[i], world, out_bodies[w, i])


@entry_point
def read_bodies(
    bodies: Float64[Array, "worlds numbers"],
    touching: Bool[Array, " worlds"],
    first: int,
    last: int,
    robots: Array,
    worlds: Array,
) -> None:
    """Poses from rows of x, y and angle, as the engine left them in the worlds that it moved.

    Only worlds first .. last - 1.
    """
    for w in range(first, last):
        if touching[w]:
            swarm = robots[w]
            for i in range(swarm.shape[0]):
                pose = swarm[i].pose
                pose[0], pose[1] = bodies[w, 3 * i], bodies[w, 3 * i + 1]
                pose[2] = wrap(bodies[w, 3 * i + 2])
            worlds[w].has_moved = True
