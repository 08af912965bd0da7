"""The tick on a GPU: the functions of a robot on a grid of threads, a thread for each robot.

A block of threads runs a few whole worlds: `cuda.threadIdx.y` tells which of them, and
`cuda.threadIdx.x` which robot. Threads of worlds with more robots than `cuda.blockDim.x` do every
so-many-th. The threads of a block wait for each other where one reads what another has written.
Threads beyond the last world have no robots, and wait with the others.

What follows from the order in which robots are gone through, the resolving of contacts, is left to
the first thread of a world, and is run only where robots overlap.
"""

from typing import Any

from swarm_forage_env.arrays import Array, Float64, Int8, Int32, Int64
from swarm_forage_env.compiler import kernel
from swarm_forage_env.equations.contacts import keep_inside
from swarm_forage_env.equations.neighbours import cell_of, cells_of
from swarm_forage_env.foraging.control import act, compose_message, take_in_all
from swarm_forage_env.foraging.fault_effects import update_faults
from swarm_forage_env.foraging.floor import move_areas
from swarm_forage_env.foraging.global_state import put_log
from swarm_forage_env.foraging.obstacle_contacts import resolve_contacts_among
from swarm_forage_env.foraging.records import WorldState
from swarm_forage_env.foraging.scoring import count_reports, score
from swarm_forage_env.foraging.surroundings import COUNT, FIRST, resolve_contacts
from swarm_forage_env.foraging.tick import drive, face, hear, sense, set_wheels
from swarm_forage_env.interface import NOT_FINITE, TOO_MANY_NEAR, Kernel

cuda: Any
is_listening: Kernel
"""Free names of the templates: threads of the GPU, and functions of the chosen layers."""


@kernel
def cell_at(swarm: Array, i: int, world: WorldState) -> int:
    """The number of the cell of the grid over the arena in which robot i is."""
    n_x, n_y = cells_of(world.arena[0], world.reach), cells_of(world.arena[1], world.reach)
    k_x = cell_of(swarm[i].pose[0], world.arena[0], world.reach, n_x)
    k_y = cell_of(swarm[i].pose[1], world.arena[1], world.reach, n_y)
    return k_x * n_y + k_y


@kernel
def is_within_reach(swarm: Array, i: int, j: int, world: WorldState) -> bool:
    """Two robots are neighbours."""
    dx, dy = swarm[j].pose[0] - swarm[i].pose[0], swarm[j].pose[1] - swarm[i].pose[1]
    return bool(dx * dx + dy * dy < world.reach * world.reach)


@kernel
def list_neighbours(
    swarm: Array, i: int, near: Int32[Array, "robots columns"], world: WorldState
) -> int:
    """Write the row of robot i as `find_neighbours` does; how many neighbours it has.

    Those with lower numbers cell by cell, the highest number of a cell first; then those with
    higher ones. All other robots are looked at, which needs no list of cells to be shared.
    """
    n_near, room = 0, near.shape[1] - FIRST
    for j in range(i):
        if is_within_reach(swarm, i, j, world):
            at = min(n_near, room - 1)
            cell = cell_at(swarm, j, world)
            while at > 0 and cell_at(swarm, near[i, FIRST + at - 1], world) >= cell:
                near[i, FIRST + at] = near[i, FIRST + at - 1]
                at -= 1
            near[i, FIRST + at] = j
            n_near += 1
    for j in range(i + 1, swarm.shape[0]):
        if is_within_reach(swarm, i, j, world):
            if n_near < room:
                near[i, FIRST + n_near] = j
            n_near += 1
    near[i, COUNT] = min(n_near, room)
    return n_near


@kernel
def is_overlapping(
    swarm: Array, i: int, near: Int32[Array, "robots columns"], world: WorldState
) -> bool:
    """Robot i may overlap a neighbour with a lower number."""
    apart = 2.0 * world.radius * 1.000001
    for k in range(FIRST, FIRST + near[i, COUNT]):
        j = near[i, k]
        if j > i:
            break
        dx, dy = swarm[j].pose[0] - swarm[i].pose[0], swarm[j].pose[1] - swarm[i].pose[1]
        if dx * dx + dy * dy < apart * apart:
            return True
    return False


def tick_on_grid(  # noqa: C901, PLR0913 stage after stage, each a loop over robots
    robots: Array,
    worlds: Array,
    near: Int32[Array, "worlds robots columns"],
    obstacles: Float64[Array, "worlds obstacles 5"],
    crowded: Int8[Array, " worlds"],
    earned: Float64[Array, "worlds robots"],
    trouble: Int64[Array, "4"],
    runs: Int8[Array, " worlds"],
) -> None:
    """One tick of the worlds that run, as `tick`. Free name: cuda."""
    w = cuda.blockIdx.x * cuda.blockDim.y + cuda.threadIdx.y
    n = robots.shape[1] if w < robots.shape[0] and runs[w] else 0
    first, step = cuda.threadIdx.x, cuda.blockDim.x
    leads = n > 0 and first == 0
    if leads:
        worlds[w].ticks += 1
        move_areas(worlds[w])
        crowded[w] = worlds[w].n_obstacles > 0
    for i in range(first, n, step):
        set_wheels(robots[w, i], worlds[w])
        drive(robots[w, i], worlds[w])
    cuda.syncthreads()
    for i in range(first, n, step):
        if list_neighbours(robots[w], i, near[w], worlds[w]) > near.shape[2] - FIRST:
            cuda.atomic.max(trouble, TOO_MANY_NEAR, w + 1)
    cuda.syncthreads()
    for i in range(first, n, step):
        keep_inside(robots[w, i].pose, worlds[w].arena, worlds[w].radius)
    cuda.syncthreads()
    for i in range(first, n, step):
        if is_overlapping(robots[w], i, near[w], worlds[w]):
            crowded[w] = 1
    cuda.syncthreads()
    if leads and crowded[w]:
        standing = obstacles[w, : worlds[w].n_obstacles]
        if worlds[w].n_obstacles == 0:
            resolve_contacts(robots[w], near[w], worlds[w])
        else:
            resolve_contacts_among(robots[w], near[w], worlds[w], standing)
    cuda.syncthreads()
    for i in range(first, n, step):
        robot = robots[w, i]
        face(robot)
        score(robot, worlds[w])
        count_reports(robot, worlds[w])
        earned[w, i] += robot.reward
        if worlds[w].has_faults:
            update_faults(robot, worlds[w])
    cuda.syncthreads()
    for i in range(first, n, step):
        standing = obstacles[w, : worlds[w].n_obstacles]
        sense(robots[w], i, near[w], worlds[w], standing)
        hear(robots[w], i, near[w], worlds[w], standing)


def observe_on_grid(
    robots: Array, minds: Array, shared: Array, settings: Array, runs: Int8[Array, " worlds"]
) -> None:
    """Take in what was sensed and heard in the worlds that run, as `observe`.

    First the messages to which somebody listens are marked, then composed, each by its sender.
    Robots that have the same numbers share the one column of `settings`.
    Free names: cuda, is_listening; those of compose_message and of take_in_all.
    """
    w = cuda.blockIdx.x * cuda.blockDim.y + cuda.threadIdx.y
    n = robots.shape[1] if w < robots.shape[0] and runs[w] else 0
    first, step, last = cuda.threadIdx.x, cuda.blockDim.x, settings.shape[1] - 1
    for i in range(first, n, step):
        if is_listening(minds[w, i]):
            for slot in range(robots[w, i].heard.n):
                minds[w, robots[w, i].heard.sender[slot]].is_composed = True
    cuda.syncthreads()
    for i in range(first, n, step):
        if minds[w, i].is_composed:
            numbers = settings[w, min(i, last)].estimator
            compose_message(robots[w, i], minds[w, i], numbers)
    cuda.syncthreads()
    for i in range(first, n, step):
        numbers = settings[w, min(i, last)].estimator
        take_in_all(robots[w], minds[w], i, shared[w, i], numbers)


def decide_on_grid(  # noqa: PLR0913 what a robot decides on, and where
    robots: Array,
    minds: Array,
    memories: Array,
    shared: Array,
    settings: Array,
    trouble: Int64[Array, "4"],
    runs: Int8[Array, " worlds"],
) -> None:
    """Steer, merge and choose whether to speak in the worlds that run, as `decide`.

    Free names: cuda; those of act.
    """
    w = cuda.blockIdx.x * cuda.blockDim.y + cuda.threadIdx.y
    n = robots.shape[1] if w < robots.shape[0] and runs[w] else 0
    last = settings.shape[1] - 1
    for i in range(cuda.threadIdx.x, n, cuda.blockDim.x):
        own = settings[w, min(i, last)]
        if not act(robots[w, i], minds[w, i], memories[w, i], shared[w, i], own):
            cuda.atomic.max(trouble, NOT_FINITE, w + 1)


def log_on_grid(
    robots: Array,
    minds: Array,
    worlds: Array,
    learners: Int64[Array, " learners"],
    out: Float64[Array, "worlds learners infos"],
) -> None:
    """Write what is logged of each learner, as `write_log`. Free name: cuda."""
    w = cuda.blockIdx.x * cuda.blockDim.y + cuda.threadIdx.y
    n = out.shape[1] if w < out.shape[0] else 0
    for learner in range(cuda.threadIdx.x, n, cuda.blockDim.x):
        i = learners[learner]
        put_log(robots[w, i], minds[w, i].situation, worlds[w], out[w, learner])
