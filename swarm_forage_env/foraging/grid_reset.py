"""Worlds that start anew on a GPU, as a reset of the CPU starts them; the other worlds go on.

Templates over the grid of `foraging/grid.py`. Every draw is that of the CPU, from the same streams.
"""

from typing import Any

from swarm_forage_env.arrays import Array, Float64, Int8, Int32, Int64, UInt64
from swarm_forage_env.equations.random_draws import first_word
from swarm_forage_env.foraging.fault_effects import update_faults
from swarm_forage_env.foraging.floor import put_areas_back
from swarm_forage_env.foraging.grid import list_neighbours
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.foraging.scoring import place_in_circle
from swarm_forage_env.foraging.surroundings import FIRST
from swarm_forage_env.foraging.tick import face, sense
from swarm_forage_env.foraging.world import SOURCES
from swarm_forage_env.interface import NO_ROOM, TOO_MANY_NEAR, Kernel
from swarm_forage_env.random_streams import NoiseSource

cuda: Any
set_stream: Kernel
"""Free names of the templates: threads of the GPU, and what starts the stream of a motion."""

PLACE = int(NoiseSource.PLACE)
CAUSES = tuple(map(int, SOURCES))
"""What each column of a robot's streams is for."""


def restarts(scenario: Scenario) -> bool:
    """Whether a GPU starts worlds of this scenario anew: faults are drawn in NumPy."""
    return not scenario.faults.is_any


def place_on_grid(  # noqa: PLR0913 what robots start from, and where they are placed
    robots: Array,
    worlds: Array,
    first_robot: Array,
    seeds: UInt64[Array, " worlds"],
    is_new: Int8[Array, " worlds"],
    places: UInt64[Array, "worlds robots"],
    poses: Float64[Array, "worlds robots 3"],
    trouble: Int64[Array, "4"],
) -> None:
    """Put the robots of new worlds at their starting places, and their streams at their seeds.

    The first thread of a world places all its robots, as each keeps clear of those before it.
    Actions stay as they were. Free name: cuda.
    """
    w = cuda.blockIdx.x * cuda.blockDim.y + cuda.threadIdx.y
    n = robots.shape[1] if w < robots.shape[0] and is_new[w] else 0
    first, step = cuda.threadIdx.x, cuda.blockDim.x
    for i in range(first, n, step):
        places[w, i] = first_word(seeds[w], i, PLACE)
    cuda.syncthreads()
    if n > 0 and first == 0:
        world = worlds[w]
        world.ticks, world.has_moved = 0, False
        put_areas_back(world)
        if place_in_circle(world.start_radius, 2.0 * world.radius, places[w], poses[w]) < n:
            cuda.atomic.max(trouble, NO_ROOM, w + 1)
    cuda.syncthreads()
    for i in range(first, n, step):
        action = robots[w, i].action
        weighting, motion = action.weighting, action.motion
        g_nest, g_prey = action.weight[0], action.weight[1]
        left, right = action.wheels[0], action.wheels[1]
        robots[w, i] = first_robot[0]
        robot = robots[w, i]
        robot.action.weighting, robot.action.motion = weighting, motion
        robot.action.weight[0], robot.action.weight[1] = g_nest, g_prey
        robot.action.wheels[0], robot.action.wheels[1] = left, right
        for k in range(3):
            robot.pose[k] = poses[w, i, k]
        for column in range(len(CAUSES)):
            robot.streams[column] = first_word(seeds[w], i, CAUSES[column])


def forget_on_grid(  # noqa: PLR0913 what robots keep, and what they start from
    minds: Array,
    memories: Array,
    first_mind: Array,
    first_memory: Array,
    seeds: UInt64[Array, " worlds"],
    is_new: Int8[Array, " worlds"],
    noise: int,
) -> None:
    """Let the layers of all robots of new worlds forget everything.

    `noise` is what their motions draw for. Free names: cuda, set_stream.
    """
    w = cuda.blockIdx.x * cuda.blockDim.y + cuda.threadIdx.y
    n = minds.shape[1] if w < minds.shape[0] and is_new[w] else 0
    for i in range(cuda.threadIdx.x, n, cuda.blockDim.x):
        minds[w, i], memories[w, i] = first_mind[0], first_memory[0]
        set_stream(memories[w, i], first_word(seeds[w], i, noise))


def sense_first_on_grid(
    robots: Array,
    worlds: Array,
    near: Int32[Array, "worlds robots columns"],
    obstacles: Float64[Array, "worlds obstacles 5"],
    is_new: Int8[Array, " worlds"],
    trouble: Int64[Array, "4"],
) -> None:
    """What is sensed in new worlds before the first tick, as `sense_first`. Free name: cuda."""
    w = cuda.blockIdx.x * cuda.blockDim.y + cuda.threadIdx.y
    n = robots.shape[1] if w < robots.shape[0] and is_new[w] else 0
    first, step = cuda.threadIdx.x, cuda.blockDim.x
    for i in range(first, n, step):
        if list_neighbours(robots[w], i, near[w], worlds[w]) > near.shape[2] - FIRST:
            cuda.atomic.max(trouble, TOO_MANY_NEAR, w + 1)
        face(robots[w, i])
        robots[w, i].heard.n = 0
        if worlds[w].has_faults:
            update_faults(robots[w, i], worlds[w])
    cuda.syncthreads()
    for i in range(first, n, step):
        standing = obstacles[w, : worlds[w].n_obstacles]
        sense(robots[w], i, near[w], worlds[w], standing)
