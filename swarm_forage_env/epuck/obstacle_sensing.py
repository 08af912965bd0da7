"""What obstacles do to the sensors and to the radio of one robot."""

import math

from swarm_forage_env.arrays import Array, Float64, Int32
from swarm_forage_env.compiler import kernel
from swarm_forage_env.epuck.records import EpuckState, EpuckWorldState
from swarm_forage_env.epuck.surroundings import COUNT, FIRST
from swarm_forage_env.equations.elementary import hypot
from swarm_forage_env.equations.obstacles import from_axis, is_between, ray_to_capsule
from swarm_forage_env.equations.proximity import RAY_COS, RAY_SIN, SENSING_RANGE


@kernel
def cast_rays_at_obstacles(
    robot: EpuckState, world: EpuckWorldState, obstacles: Float64[Array, "obstacles 5"]
) -> None:
    """Set the infrared rays of a robot to their lengths up to the obstacles; else infinite."""
    robot.rays[:] = math.inf
    for k in range(obstacles.shape[0]):
        dx, dy = from_axis(robot.pose[0], robot.pose[1], obstacles[k])
        if hypot(dx, dy) < world.radius + SENSING_RANGE + obstacles[k, 4]:
            shorten_rays_at_obstacle(robot, world, obstacles[k])


@kernel
def shorten_rays_at_obstacle(
    robot: EpuckState, world: EpuckWorldState, capsule: Float64[Array, "5"]
) -> None:
    """Shorten the rays of a robot that a capsule stands in the way of."""
    x, y, c, s = robot.pose[0], robot.pose[1], robot.heading[0], robot.heading[1]
    for ray in range(8):
        u = c * RAY_COS[ray] - s * RAY_SIN[ray]
        v = s * RAY_COS[ray] + c * RAY_SIN[ray]
        d = max(ray_to_capsule(x, y, u, v, capsule) - world.radius, 0.0)
        robot.rays[ray] = min(robot.rays[ray], d)


@kernel
def is_shadowed(
    robot: EpuckState, sender: EpuckState, obstacles: Float64[Array, "obstacles 5"]
) -> bool:
    """An obstacle stands between the centres of two robots."""
    here, there = robot.pose, sender.pose
    for k in range(obstacles.shape[0]):
        if is_between(here[0], here[1], there[0], there[1], obstacles[k]):
            return True
    return False


@kernel
def put_shadowed_last(
    swarm: Array,
    i: int,
    near: Int32[Array, "robots columns"],
    obstacles: Float64[Array, "obstacles 5"],
) -> int:
    """Put those neighbours of robot i that an obstacle hides last in its row; how many it does not.

    The neighbours that stay in front keep no order.
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
