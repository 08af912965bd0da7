"""The foraging task: where robots start, and what counts as a visit and a round trip."""

import math

from swarm_forage_env.arrays import NEST, PREY, Array, Float64, UInt64
from swarm_forage_env.compiler import kernel
from swarm_forage_env.equations.geometry import to_outer
from swarm_forage_env.equations.ground import FLOOR
from swarm_forage_env.equations.random_draws import symmetric, unit
from swarm_forage_env.foraging.floor import number_at
from swarm_forage_env.foraging.records import RobotState, WorldState

TO_FIRST_NEST, TO_PREY, TO_NEST = 0, 1, 2


@kernel
def place_in_circle(
    radius: float,
    apart: float,
    streams: UInt64[Array, " robots"],
    out_pose: Float64[Array, "robots 3"],
) -> int:
    """Put robots at random into a circle about the origin, none closer than `apart` [m].

    Positions uniform among the free ones, headings uniform; when somebody finds no place,
    all start over. Returns how many found a place in the last try: fewer than asked for
    means that the circle is too full.
    """
    n_robots = out_pose.shape[0]
    placed = 0
    for _ in range(200):
        placed = 0
        while placed < n_robots and place_next(radius, apart, streams, placed, out_pose):
            placed += 1
        if placed == n_robots:
            break
    return placed


@kernel
def place_next(
    radius: float,
    apart: float,
    streams: UInt64[Array, " robots"],
    i: int,
    out_pose: Float64[Array, "robots 3"],
) -> bool:
    """Put robot i clear of robots 0 .. i - 1; false if 10,000 draws hit none of the free places."""
    for _ in range(10_000):
        r = radius * math.sqrt(unit(streams, i))
        angle = math.pi * symmetric(streams, i)
        x, y = r * math.cos(angle), r * math.sin(angle)
        if is_free(x, y, apart, out_pose, i):
            out_pose[i, 0], out_pose[i, 1] = x, y
            out_pose[i, 2] = math.pi * symmetric(streams, i)
            return True
    return False


@kernel
def is_free(x: float, y: float, apart: float, pose: Float64[Array, "robots 3"], n: int) -> bool:
    """No centre of the first n robots is closer to (x, y) than `apart` [m]."""
    for j in range(n):
        dx, dy = pose[j, 0] - x, pose[j, 1] - y
        if dx * dx + dy * dy < apart * apart:
            return False
    return True


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
def score(robot: RobotState, world: WorldState) -> None:
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
