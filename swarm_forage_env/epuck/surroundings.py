"""Lists of the neighbours of each robot in a world."""

from swarm_forage_env.arrays import Array, Int32
from swarm_forage_env.compiler import kernel
from swarm_forage_env.epuck.records import EpuckWorldState
from swarm_forage_env.equations.neighbours import EMPTY, cell_of, cells_of
from swarm_forage_env.interface import Kernel
from swarm_forage_env.templates import row_template

lane: Kernel
lanes: Kernel
"""Free names of the row templates."""

Neighbours = Int32[Array, "robots columns"]
"""Neighbour list of a world: one row for each robot, with columns COUNT, NEXT, FIRST ..."""

COUNT, NEXT, FIRST = 0, 1, 2
"""Columns of a robot's row of `near`: the number of neighbours, the next robot in its cell, and the
first of the neighbours' indices."""


FEW = 16
"""Up to this number of robots, comparing all pairs is faster than a list of cells."""


@kernel
def is_within_reach(swarm: Array, i: int, j: int, world: EpuckWorldState) -> bool:
    """Return whether two robots are neighbours."""
    dx, dy = swarm[j].pose[0] - swarm[i].pose[0], swarm[j].pose[1] - swarm[i].pose[1]
    return bool(dx * dx + dy * dy < world.reach * world.reach)


@kernel
def note_neighbour(near: Neighbours, i: int, j: int) -> None:
    """Insert robot j into the row of robot i, in order, if there is room; count it in any case."""
    n = near[i, COUNT]
    near[i, COUNT] += 1
    if FIRST + n >= near.shape[1]:
        return
    at = FIRST + n
    while at > FIRST and near[i, at - 1] > j:
        near[i, at] = near[i, at - 1]
        at -= 1
    near[i, at] = j


@kernel
def largest_count(near: Neighbours) -> int:
    """Return the largest number of neighbours, and limit all counts to the capacity of a row."""
    most = 0
    for i in range(near.shape[0]):
        most = max(most, near[i, COUNT])
        near[i, COUNT] = min(near[i, COUNT], near.shape[1] - FIRST)
    return most


@kernel
def compare_all_pairs(swarm: Array, near: Neighbours, world: EpuckWorldState) -> int:
    """List the neighbours of each robot as `find_neighbours` does, without cells."""
    for i in range(swarm.shape[0]):
        near[i, COUNT] = 0
        for j in range(i):
            if is_within_reach(swarm, i, j, world):
                note_neighbour(near, i, j)
                note_neighbour(near, j, i)
    return largest_count(near)


@kernel
def find_neighbours(
    swarm: Array, near: Neighbours, cells: Int32[Array, " cells"], world: EpuckWorldState
) -> int:
    """List the robots within `reach` of each robot; return the largest number of neighbours.

    The indices in a row ascend. Neighbours without room in a row are left out, but are counted in
    the return value. `cells` must be EMPTY everywhere, and is EMPTY again afterwards.
    """
    n_x, n_y = cells_of(world.arena[0], world.reach), cells_of(world.arena[1], world.reach)
    for i in range(swarm.shape[0]):
        near[i, COUNT] = 0
    for i in range(swarm.shape[0]):
        cx = cell_of(swarm[i].pose[0], world.arena[0], world.reach, n_x)
        cy = cell_of(swarm[i].pose[1], world.arena[1], world.reach, n_y)
        for kx in range(max(cx - 1, 0), min(cx + 2, n_x)):
            for ky in range(max(cy - 1, 0), min(cy + 2, n_y)):
                j = cells[kx * n_y + ky]
                while j != EMPTY:
                    if is_within_reach(swarm, i, j, world):
                        note_neighbour(near, i, j)
                        note_neighbour(near, j, i)
                    j = near[j, NEXT]
        near[i, NEXT] = cells[cx * n_y + cy]
        cells[cx * n_y + cy] = i
    for i in range(swarm.shape[0]):
        cx = cell_of(swarm[i].pose[0], world.arena[0], world.reach, n_x)
        cy = cell_of(swarm[i].pose[1], world.arena[1], world.reach, n_y)
        cells[cx * n_y + cy] = EMPTY
    return largest_count(near)


@kernel
def find_neighbours_of(swarm: Array, i: int, near: Neighbours, world: EpuckWorldState) -> int:
    """Write the row of robot i, without cells shared by lanes; return its number of neighbours."""
    n_near, capacity = 0, near.shape[1] - FIRST
    for j in range(swarm.shape[0]):
        if j != i and is_within_reach(swarm, i, j, world):
            if n_near < capacity:
                near[i, FIRST + n_near] = j
            n_near += 1
    near[i, COUNT] = min(n_near, capacity)
    return n_near


@row_template
def list_by_cells(
    swarm: Array,
    near: Neighbours,
    cells: Int32[Array, " cells"],
    world: EpuckWorldState,
    n_robots: int,
) -> int:
    """List neighbours in a single lane, fastest on a CPU; return the largest number."""
    if n_robots == 0:
        return 0
    if n_robots <= FEW:
        return compare_all_pairs(swarm, near, world)
    return find_neighbours(swarm, near, cells, world)


@row_template
def list_by_robots(
    swarm: Array,
    near: Neighbours,
    cells: Int32[Array, " cells"],
    world: EpuckWorldState,
    n_robots: int,
) -> int:
    """List neighbours robot by robot, as lanes share the work; return the largest number of one."""
    most = 0
    for i in range(lane(), n_robots, lanes()):
        most = max(most, find_neighbours_of(swarm, i, near, world))
    return most
