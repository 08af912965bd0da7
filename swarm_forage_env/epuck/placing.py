"""Start positions of e-pucks: in a circle about the arena's centre, without overlaps."""

import math

import numpy as np

from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.compiler import kernel
from swarm_forage_env.epuck.fault_draws import draw_fault
from swarm_forage_env.epuck.records import EpuckState
from swarm_forage_env.equations.elementary import cos_sin
from swarm_forage_env.equations.random_draws import Streams, first_word, symmetric, unit
from swarm_forage_env.interface import Kernel
from swarm_forage_env.random_streams import NoiseSource
from swarm_forage_env.templates import row_template
from swarm_forage_env.ticks import NO_ROOM, Arrays, Errors, note

lane: Kernel
lanes: Kernel
barrier: Kernel
"""Free names of the template."""

SOURCES = tuple(map(NoiseSource, range(NoiseSource.ENCODER, NoiseSource.RADIO + 1)))
"""Noise source of each column of a robot's random streams."""

PLACE = int(NoiseSource.PLACE)
CAUSES = tuple(map(int, SOURCES))


@kernel
def place_in_circle(
    radius: float, apart: float, streams: Streams, out_pose: Float64[Array, "robots 3"]
) -> int:
    """Place robots at random in a circle about the origin, none closer than `apart` [m].

    Positions are uniform among the free ones, headings are uniform. If a robot finds no place, all
    are placed again. Returns the number of robots placed in the last attempt: fewer than all if
    the circle is too full.
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
    radius: float, apart: float, streams: Streams, i: int, out_pose: Float64[Array, "robots 3"]
) -> bool:
    """Place robot i clear of robots 0 .. i - 1; return false if 10,000 draws find no free place."""
    for _ in range(10_000):
        r = radius * math.sqrt(unit(streams, i))
        angle = math.pi * symmetric(streams, i)
        c, s = cos_sin(angle)
        x, y = r * c, r * s
        if is_free(x, y, apart, out_pose, i):
            out_pose[i, 0], out_pose[i, 1] = x, y
            out_pose[i, 2] = math.pi * symmetric(streams, i)
            return True
    return False


@kernel
def is_free(x: float, y: float, apart: float, pose: Float64[Array, "robots 3"], n: int) -> bool:
    """Return whether none of the first n robots is closer to (x, y) than `apart` [m]."""
    for j in range(n):
        dx, dy = pose[j, 0] - x, pose[j, 1] - y
        if dx * dx + dy * dy < apart * apart:
            return False
    return True


@row_template
def place_world(  # noqa: PLR0913 inputs and outputs
    world_arrays: Arrays,
    first_robot: EpuckState,
    seed: np.uint64,
    places: Streams,
    poses: Float64[Array, "robots 3"],
    errors: Errors,
    w: int,
    n_robots: int,
) -> None:
    """Place the robots of a new world, and start their random streams and faults from its seed.

    The first lane places all robots, as each must keep clear of those before it. Actions are kept.
    """
    robots, world, faults = world_arrays[0], world_arrays[1][w], world_arrays[6]
    for i in range(lane(), n_robots, lanes()):
        places[i] = first_word(seed, i, PLACE)
    barrier()
    if n_robots > 0 and lane() == 0:
        world.ticks, world.has_moved = 0, False
        if place_in_circle(world.start_radius, 2.0 * world.radius, places, poses) < n_robots:
            note(errors, w, NO_ROOM, 0)
    barrier()
    for i in range(lane(), n_robots, lanes()):
        action = robots[w, i].action
        weighting, motion = action.weighting, action.motion
        has_reflexes, is_walking = action.has_reflexes, action.is_walking
        g_nest, g_prey = action.weight[0], action.weight[1]
        left, right = action.wheels[0], action.wheels[1]
        robots[w, i] = first_robot
        robot = robots[w, i]
        robot.action.weighting, robot.action.motion = weighting, motion
        robot.action.has_reflexes, robot.action.is_walking = has_reflexes, is_walking
        robot.action.weight[0], robot.action.weight[1] = g_nest, g_prey
        robot.action.wheels[0], robot.action.wheels[1] = left, right
        for k in range(3):
            robot.pose[k] = poses[i, k]
        for column in range(len(CAUSES)):
            robot.streams[column] = first_word(seed, i, CAUSES[column])
        if world.has_faults:
            draw_fault(world.faults, seed, i, n_robots, faults[w, i])


def place_worlds(
    world_arrays: Arrays, starts: Arrays, errors: Errors, first: int, last: int
) -> None:
    """Place the robots of worlds first .. last - 1 by `place_world`; `starts`: those of `World`."""
    first_robot, seeds, places, poses = starts
    for w in range(first, last):
        n_robots = poses.shape[1]
        place_world(
            world_arrays, first_robot[0], seeds[w], places[w], poses[w], errors, w, n_robots
        )
