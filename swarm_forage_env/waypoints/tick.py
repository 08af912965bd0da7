"""The tick of the waypoints world: claims are judged, everyone moves, senses and sees."""

from swarm_forage_env.arrays import Array, UInt64
from swarm_forage_env.compiler import entry_point, kernel
from swarm_forage_env.waypoints.dynamics import draw_devices, drive, judge_claim, place_at_home
from swarm_forage_env.waypoints.records import RobotState
from swarm_forage_env.waypoints.sensors import (
    fix_at_home,
    measure_motion,
    read_goal,
    see_each_other,
)


@entry_point
def tick(robots: Array, sightings: Array, worlds: Array, first: int, last: int) -> None:
    """One tick of the worlds first .. last - 1."""
    for w in range(first, last):
        world, swarm = worlds[w], robots[w]
        world.ticks += 1
        for i in range(swarm.shape[0]):
            judge_claim(swarm[i], world)
            drive(swarm[i], world)
            measure_motion(swarm[i])
            fix_at_home(swarm[i], world)
            read_goal(swarm[i])
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


@entry_point
def sense_first(robots: Array, sightings: Array, worlds: Array, first: int, last: int) -> None:
    """What is sensed before the first tick: an exact fix, no motion, and each other."""
    for w in range(first, last):
        swarm = robots[w]
        for i in range(swarm.shape[0]):
            read_start(swarm[i])
            read_goal(swarm[i])
        see_each_other(swarm, sightings[w], worlds[w])


@kernel
def read_start(robot: RobotState) -> None:
    """The exact fix that a robot begins with."""
    robot.readings.at_home = True
    for k in range(3):
        robot.readings.home_fix[k] = robot.pose[k]
