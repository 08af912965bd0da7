"""Neighbours: which robots of a world are close, found with a grid of cells."""

import math

from swarm_forage_env.compiler import kernel

EMPTY = -1


@kernel
def cells_of(side: float, reach: float) -> int:
    """How many cells of at least `reach` [m] an axis of this length [m] has."""
    return max(1, math.floor(side / reach))


@kernel
def cell_of(coordinate: float, side: float, reach: float, cells: int) -> int:
    """Index of the grid cell of a coordinate [m] on an axis of the arena of that side [m].

    Cells are at least `reach` wide; what lies outside the walls counts to the outermost cell.
    """
    k = math.floor((coordinate + 0.5 * side) / reach)
    return min(max(k, 0), cells - 1)
