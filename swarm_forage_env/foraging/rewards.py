"""Inputs of foraging rewards: the events of a tick, and the potential for shaping."""

import math

import numpy as np

from swarm_forage_env.arrays import NEST, PREY, Array, Float64, Int32
from swarm_forage_env.compiler import entry_point, kernel
from swarm_forage_env.epuck.contacts import is_near_obstacle, is_near_walls
from swarm_forage_env.epuck.records import AREAS
from swarm_forage_env.epuck.surroundings import COUNT, FIRST
from swarm_forage_env.equations.elementary import hypot
from swarm_forage_env.equations.geometry import to_outer
from swarm_forage_env.equations.ground import FLOOR
from swarm_forage_env.foraging.records import RobotState, WorldState
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.foraging.scoring import distance_to_kind, kind_at
from swarm_forage_env.foraging.world import ForagingWorld
from swarm_forage_env.record import field
from swarm_forage_env.task import Events, Potential

TOUCH = 1e-3
"""Gap below which bodies are in contact with each other, a wall or an obstacle [m]."""


class ForagingEvents(Events):
    """Events of one robot in the last tick."""

    trip: bool = field(np.bool_)
    """Whether the robot completed a round trip nest -> prey -> nest."""
    visit: int = field(np.int32, start=FLOOR)
    """Area that the robot entered: 0 nest, 1 prey; -1 none, or it was there before."""
    loss: bool = field(np.bool_)
    """Whether the robot got lost and forgot the areas."""
    contact: bool = field(np.bool_)
    """Whether the robot touches another robot, a wall or an obstacle."""
    message: int = field(np.int32)
    """Number of messages that the robot received."""

    @staticmethod
    def write(world: ForagingWorld, before: Array, out: Array) -> None:
        """Write the events of the robots of these worlds since the records `before`."""
        write_events(world.robots, before, world.worlds, world.near, world.obstacles, out)


@kernel
def area_under(robot: RobotState, world: WorldState) -> int:
    """Return the area under the middle ground sensor of a robot, as used by `score`."""
    dx, dy = to_outer(world.ground_ahead, 0.0, robot.heading[0], robot.heading[1])
    return kind_at(robot.pose[0] + dx, robot.pose[1] + dy, world)


@kernel
def is_touching(swarm: Array, i: int, near: Int32[Array, " columns"], world: WorldState) -> bool:
    """Return whether robot i touches another robot."""
    x, y = swarm[i].pose[0], swarm[i].pose[1]
    for k in range(FIRST, FIRST + near[COUNT]):
        other = swarm[near[k]].pose
        if hypot(other[0] - x, other[1] - y) <= 2.0 * world.radius + TOUCH:
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
            event.contact = (
                is_touching(robots[w], i, near[w, i], worlds[w])
                or is_near_walls(robot, worlds[w], TOUCH)
                or is_near_obstacle(robot, worlds[w], standing, TOUCH)
            )
            event.message = robot.heard.n


LEGS = 3
"""Number of legs: to the first nest, to the prey, back to the nest."""


@kernel
def farthest(world: WorldState) -> float:
    """Return the largest possible distance of a robot from the centre of an area [m]."""
    x, y = 0.0, 0.0
    for k in range(world.n_areas):  # the record may hold areas of an earlier scenario
        x, y = max(x, abs(world.areas[k, 0])), max(y, abs(world.areas[k, 1]))
    return float(hypot(0.5 * world.arena[0] + x, 0.5 * world.arena[1] + y))


@kernel
def potential(robot: RobotState, world: WorldState) -> float:
    """Return the progress of a robot on its round trip, from the true state, in [0, 1].

        Phi = (leg + 1 - d / far) / 3

    leg counts nest (first visit), prey, nest; d is the true distance to the centre of the nearest
    area of the kind that the leg leads to [m], far the largest possible distance [m], both in the
    robot's own world.

    Not in the paper: the potential itself; and a truncated episode keeps the potential of its last
    state, as its value is bootstrapped.

    Source: Ng1999, Theorem 1, for shaping by a potential.
    """
    kind = NEST if robot.leg % 2 == 0 else PREY
    d = distance_to_kind(robot.pose[0], robot.pose[1], kind, world)
    return float((robot.leg + 1.0 - min(d / farthest(world), 1.0)) / LEGS)


def max_shaping(scenario: Scenario) -> tuple[float, str]:
    """Return the largest weight w of the potential in a scenario, and the reason in words.

    The potential falls from 1 to 1/3 when a trip ends and the next begins, so that a trip worth v
    pays v - 2 w / 3 in that tick; the trip worth least must not pay less than 0.
    """
    areas = scenario.task.areas
    worths = [[each.worth for each in areas if each.kind == kind] for kind in AREAS]
    least = math.prod(min(each, default=1.0) for each in worths)
    why = f"a completed trip pays {least:g} - 2 w / 3 in its tick, which would be below zero"
    return least * LEGS / (LEGS - 1), why


FORAGING_POTENTIAL = Potential(potential, max_shaping)
