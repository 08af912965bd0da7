"""What happened to each robot in a tick, for rewards of the user's own."""

import numpy as np

from swarm_forage_env.arrays import Array, Float64, Int32
from swarm_forage_env.compiler import entry_point, kernel
from swarm_forage_env.epuck.surroundings import COUNT, FIRST
from swarm_forage_env.equations.elementary import hypot
from swarm_forage_env.equations.geometry import to_outer
from swarm_forage_env.equations.ground import FLOOR
from swarm_forage_env.equations.obstacles import from_axis
from swarm_forage_env.foraging.floor import kind_at
from swarm_forage_env.foraging.records import RobotState, WorldState
from swarm_forage_env.foraging.world import ForagingWorld
from swarm_forage_env.record import field
from swarm_forage_env.task import Events

TOUCH = 1e-3
"""Bodies within this of each other, of a wall or of an obstacle are in contact [m]."""


class ForagingEvents(Events):
    """What happened to one robot in the last tick."""

    trip: bool = field(np.bool_)
    """It completed nest -> prey -> nest."""

    visit: int = field(np.int8, start=FLOOR)
    """The area that it came to stand on: 0 nest, 1 prey; -1 none, or it stood there before."""

    loss: bool = field(np.bool_)
    """It found itself lost, and forgot where the areas are."""

    contact: bool = field(np.bool_)
    """Its body touches another, a wall or an obstacle."""

    message: int = field(np.int32)
    """Messages that it heard."""

    @staticmethod
    def write(world: ForagingWorld, before: Array, out: Array) -> None:
        """Write what happened to the robots of these worlds since they were as `before`."""
        write_events(world.robots, before, world.worlds, world.near, world.obstacles, out)


@kernel
def area_under(robot: RobotState, world: WorldState) -> int:
    """The area under the middle ground sensor of a robot, as `score` counts visits."""
    dx, dy = to_outer(world.ground_ahead, 0.0, robot.heading[0], robot.heading[1])
    return kind_at(robot.pose[0] + dx, robot.pose[1] + dy, world)


@kernel
def is_touching(swarm: Array, i: int, near: Int32[Array, " columns"], world: WorldState) -> bool:
    """The body of robot i touches another or a wall."""
    x, y = swarm[i].pose[0], swarm[i].pose[1]
    reach = world.radius + TOUCH
    if abs(x) >= 0.5 * world.arena[0] - reach or abs(y) >= 0.5 * world.arena[1] - reach:
        return True
    for k in range(FIRST, FIRST + near[COUNT]):
        other = swarm[near[k]].pose
        if hypot(other[0] - x, other[1] - y) <= 2.0 * world.radius + TOUCH:
            return True
    return False


@kernel
def is_touching_obstacle(
    robot: RobotState, world: WorldState, obstacles: Float64[Array, "obstacles 5"]
) -> bool:
    """The body of a robot touches an obstacle."""
    for k in range(obstacles.shape[0]):
        dx, dy = from_axis(robot.pose[0], robot.pose[1], obstacles[k])
        if hypot(dx, dy) <= world.radius + obstacles[k, 4] + TOUCH:
            return True
    return False


@entry_point
def write_events(
    robots: Array,
    before: Array,
    worlds: Array,
    near: Int32[Array, "worlds robots columns"],
    obstacles: Float64[Array, "worlds obstacles 5"],
    out: Array,
) -> None:
    """Write the events of every robot of every world."""
    for w in range(robots.shape[0]):
        standing = obstacles[w, : worlds[w].n_obstacles]
        for i in range(robots.shape[1]):
            robot, event = robots[w, i], out[w, i]
            area = area_under(robot, worlds[w])
            event.trip = robot.reward > 0.0
            event.visit = area if area != area_under(before[w, i], worlds[w]) else FLOOR
            event.loss = robot.report.is_lost
            event.contact = is_touching(robots[w], i, near[w, i], worlds[w])
            event.contact |= is_touching_obstacle(robot, worlds[w], standing)
            event.message = robot.heard.n
