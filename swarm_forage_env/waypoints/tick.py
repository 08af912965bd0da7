"""The tick of the waypoints world: claims are judged, everyone moves, senses and sees."""

from swarm_forage_env.arrays import Array, Int64, UInt64
from swarm_forage_env.compiler import entry_point, kernel
from swarm_forage_env.templates import row_template
from swarm_forage_env.ticks import Arrays
from swarm_forage_env.waypoints.dynamics import draw_devices, drive, judge_claim, place_at_home
from swarm_forage_env.waypoints.records import RobotState
from swarm_forage_env.waypoints.sensors import (
    fix_at_home,
    measure_motion,
    read_goal,
    see_each_other,
)


@row_template
def tick_world(
    world_arrays: Arrays, trouble: Int64[Array, " worlds_and_one"], w: int, n: int, n_moving: int
) -> None:
    """One tick of the n robots of a world; where none are moving it begins, and all sense only."""
    robots, sightings, worlds, earned = world_arrays
    swarm, world = robots[w], worlds[w]
    if n_moving > 0:
        world.ticks += 1
    for i in range(n_moving):
        judge_claim(swarm[i], world)
        earned[w, i] += swarm[i].reward
        drive(swarm[i], world)
        measure_motion(swarm[i])
        fix_at_home(swarm[i], world)
        read_goal(swarm[i])
    for i in range(n - n_moving):
        read_start(swarm[i])
        read_goal(swarm[i])
    if n > 0:
        see_each_other(swarm, sightings[w], world)


@entry_point
def judge_claims(robots: Array, worlds: Array) -> None:
    """Judge what every robot of all worlds has claimed, and do nothing else."""
    for w in range(robots.shape[0]):
        for i in range(robots.shape[1]):
            judge_claim(robots[w, i], worlds[w])


@entry_point
def start_at_home(
    robots: Array,
    worlds: Array,
    which: int,
    places: UInt64[Array, " robots"],
    devices: UInt64[Array, " robots"],
) -> None:
    """Put the robots of one world at their starting places, with devices of their own."""
    swarm, world = robots[which], worlds[which]
    for i in range(swarm.shape[0]):
        place_at_home(swarm[i], world, places, i)
        draw_devices(swarm[i], world, devices, i)


@kernel
def read_start(robot: RobotState) -> None:
    """The exact fix that a robot begins with."""
    robot.readings.at_home = True
    for k in range(3):
        robot.readings.home_fix[k] = robot.pose[k]
