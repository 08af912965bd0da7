"""Scoring of foraging: the floor, and counts of visits, round trips and ticks on the path."""

import math

from swarm_forage_env.arrays import NEST, PREY, Array
from swarm_forage_env.compiler import kernel
from swarm_forage_env.equations.elementary import hypot
from swarm_forage_env.equations.geometry import to_outer
from swarm_forage_env.equations.ground import FLOOR, area_at, brightness
from swarm_forage_env.foraging.records import RobotState, WorldState


@kernel
def number_at(x: float, y: float, world: WorldState) -> int:
    """Return the index of the area at a point of the world frame [m], or FLOOR."""
    return area_at(x, y, world.areas, world.n_areas, world.area_radius)


@kernel
def kind_at(x: float, y: float, world: WorldState) -> int:
    """Return the kind of area at a point of the world frame [m]: NEST, PREY or FLOOR."""
    number = number_at(x, y, world)
    return FLOOR if number == FLOOR else int(world.kinds[number])


@kernel
def brightness_at(x: float, y: float, world: WorldState) -> float:
    """Return the brightness of the floor at a point of the world frame [m]."""
    return brightness(kind_at(x, y, world))


@kernel
def distance_to_kind(x: float, y: float, kind: int, world: WorldState) -> float:
    """Return the distance from a point, world frame, to the nearest area centre of a kind [m]."""
    nearest = math.inf
    for k in range(world.n_areas):
        if world.kinds[k] == kind:
            nearest = min(nearest, hypot(x - world.areas[k, 0], y - world.areas[k, 1]))
    return float(nearest)


@kernel
def reset_areas(world: WorldState) -> None:
    """Move all areas to their first places."""
    for k in range(world.n_areas):
        world.areas[k, 0], world.areas[k, 1] = world.first_places[k, 0], world.first_places[k, 1]


@kernel
def move_areas(world: WorldState) -> None:
    """Move the areas that are due in this tick to their second places."""
    for k in range(world.n_areas):
        if world.ticks == world.moves_at[k]:
            world.areas[k, 0], world.areas[k, 1] = world.moves_to[k, 0], world.moves_to[k, 1]


TO_FIRST_NEST, TO_PREY, TO_NEST = 0, 1, 2


@kernel
def next_leg(leg: int, area: int) -> tuple[int, bool]:
    """Return the leg after a visit of an area, and whether that completes nest -> prey -> nest.

    Source: TR, Section 6.1.2 (the round trip).
    """
    if area == NEST:
        return TO_PREY, leg == TO_NEST
    if area == PREY and leg == TO_PREY:
        return TO_NEST, False
    return leg, False


@kernel
def score_visit(robot: RobotState, world: WorldState) -> None:
    """Count the visit and the round trip of a tick, and write the reward of the trip.

    A robot visits an area when the true position of its middle ground sensor, `ground_ahead` of its
    centre [m], is over it. It takes an item where leg 1 ends. The reward is the worth of that prey
    area times the worth of the nest.
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
    """Count reported losses and, in the second half, ticks with both areas known (on the path)."""
    robot.lost_events += robot.report.is_lost
    robot.known[NEST], robot.known[PREY] = robot.report.known[NEST], robot.report.known[PREY]
    if world.ticks > world.half_time and robot.known[NEST] and robot.known[PREY]:
        robot.path_ticks += 1


@kernel
def score(swarm: Array, i: int, world: WorldState) -> None:
    """Score robot i: its visit, its round trip, and the reports of its controller."""
    score_visit(swarm[i], world)
    count_reports(swarm[i], world)
