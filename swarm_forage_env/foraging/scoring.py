"""The foraging task: what counts as a visit, a round trip and being on the path."""

from swarm_forage_env.arrays import NEST, PREY, Array
from swarm_forage_env.compiler import kernel
from swarm_forage_env.equations.geometry import to_outer
from swarm_forage_env.equations.ground import FLOOR
from swarm_forage_env.foraging.floor import number_at
from swarm_forage_env.foraging.records import RobotState, WorldState

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
