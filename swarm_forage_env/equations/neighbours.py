"""Grid of cells for the search for neighbours in a world."""

import math

from swarm_forage_env.compiler import kernel

EMPTY = -1


@kernel
def cells_of(side: float, reach: float) -> int:
    """Return the number of cells at least `reach` [m] wide on an axis of length `side` [m]."""
    return max(1, math.floor(side / reach))


@kernel
def cell_of(coordinate: float, side: float, reach: float, cells: int) -> int:
    """Return the index of the cell that holds a coordinate [m] on an axis of length `side` [m].

    Cells are at least `reach` wide; coordinates outside the walls belong to the outermost cell.
    """
    k = math.floor((coordinate + 0.5 * side) / reach)
    return min(max(k, 0), cells - 1)
