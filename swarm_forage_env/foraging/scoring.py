"""The foraging task: the floor, and what counts as a visit, a round trip and being on the path."""

import math

from swarm_forage_env.arrays import NEST, PREY, Array
from swarm_forage_env.compiler import kernel
from swarm_forage_env.equations.elementary import hypot
from swarm_forage_env.equations.geometry import to_outer
from swarm_forage_env.equations.ground import FLOOR, area_at, brightness
from swarm_forage_env.foraging.records import RobotState, WorldState


@kernel
def number_at(x: float, y: float, world: WorldState) -> int:
    """Which area of the world holds a point of the world frame [m]: its number, or FLOOR."""
    return area_at(x, y, world.areas, world.n_areas, world.area_radius)


@kernel
def kind_at(x: float, y: float, world: WorldState) -> int:
    """What lies under a point of the world frame [m]: NEST, PREY or FLOOR."""
    number = number_at(x, y, world)
    return FLOOR if number == FLOOR else int(world.kinds[number])


@kernel
def brightness_at(x: float, y: float, world: WorldState) -> float:
    """How bright the floor is under a point of the world frame [m]."""
    return brightness(kind_at(x, y, world))


@kernel
def distance_to_kind(x: float, y: float, kind: int, world: WorldState) -> float:
    """Distance from a point of the world frame to the nearest centre of that kind of area [m]."""
    nearest = math.inf
    for k in range(world.n_areas):
        if world.kinds[k] == kind:
            nearest = min(nearest, hypot(x - world.areas[k, 0], y - world.areas[k, 1]))
    return float(nearest)


@kernel
def reset_areas(world: WorldState) -> None:
    """Put all areas where they are at the start."""
    for k in range(world.n_areas):
        world.areas[k, 0], world.areas[k, 1] = world.first_places[k, 0], world.first_places[k, 1]


@kernel
def move_areas(world: WorldState) -> None:
    """Put the areas that move in this tick at their second places."""
    for k in range(world.n_areas):
        if world.ticks == world.moves_at[k]:
            world.areas[k, 0], world.areas[k, 1] = world.moves_to[k, 0], world.moves_to[k, 1]


TO_FIRST_NEST, TO_PREY, TO_NEST = 0, 1, 2


@kernel
def next_leg(leg: int, area: int) -> tuple[int, bool]:
    """The leg after standing on an area, and whether that completes nest -> prey -> nest.

    Source: TR, Section 6.1.2 (the round trip).
    """
    if area == NEST:
        return TO_PREY, leg == TO_NEST
    if area == PREY and leg == TO_PREY:
        return TO_NEST, False
    return leg, False


@kernel
def score_visit(robot: RobotState, world: WorldState) -> None:
    """Count the visit and the round trip of a tick, and what the trip is worth.

    A robot visits an area when its middle ground sensor, `ground_ahead` of its centre [m], is
    truly over it. It takes an item where its way to the prey ends, and a trip is worth what that
    prey area is worth, times what the nest is worth.
    """
    robot.reward = 0.0
    dx, dy = to_outer(world.ground_ahead, 0.0, robot.heading[0], robot.heading[1])
    number = number_at(robot.pose[0] + dx, robot.pose[1] + dy, world)
    if number == FLOOR:
        return
    area, before = int(world.kinds[number]), robot.leg
    robot.leg, completed = next_leg(before, area)
    if completed:
        robot.round_trips += 1
        robot.reward = robot.load * world.worths[number]
    if before == TO_PREY and robot.leg == TO_NEST:
        robot.load = world.worths[number]
    if robot.first_visit[area] < 0:
        robot.first_visit[area] = world.ticks


@kernel
def count_reports(robot: RobotState, world: WorldState) -> None:
    """Count what the controller reported: losses, and ticks with both areas known.

    The latter in the second half of the episode; such a robot is on the path.
    """
    robot.lost_events += robot.report.is_lost
    robot.known[NEST], robot.known[PREY] = robot.report.known[NEST], robot.report.known[PREY]
    if world.ticks > world.half_time and robot.known[NEST] and robot.known[PREY]:
        robot.path_ticks += 1


@kernel
def score(swarm: Array, i: int, world: WorldState) -> None:
    """Score robot i: its visit and round trip, and what its controller reported."""
    score_visit(swarm[i], world)
    count_reports(swarm[i], world)
