"""Which robots are close: a cell grid over each world, and the pairs it finds."""

import math

from swarm_forage_env.arrays import Array, Bool, Float64, Int32, Int64
from swarm_forage_env.kernels.compiler import kernel

EMPTY = -1

MOST_PASSES = 2000
GENTLE_PASSES = 20
"""After so many passes a clump is left, which over-relaxation settles 3 times sooner."""
HALF, OVER_RELAXED = 0.5, 0.9
"""Share of an overlap by which each of the two discs moves."""


@kernel
def cell_of(coordinate: float, side: float, reach: float, cells: int) -> int:
    """Index of the grid cell of a coordinate [m] on an axis of the arena of that side [m].

    Cells are at least `reach` wide; what lies outside the walls counts to the outermost cell.
    """
    k = math.floor((coordinate + 0.5 * side) / reach)
    return min(max(k, 0), cells - 1)


@kernel
def note_pairs(  # noqa: PLR0913 inputs first, then the output
    pose: Float64[Array, "rows 3"],
    i: int,
    first: int,
    other: int,
    reach: float,
    following: Int32[Array, " robots"],
    n_pairs: int,
    out_pairs: Int32[Array, "capacity 2"],
) -> int:
    """Add the pairs of row i with the robots of one cell, a chain that starts at `other`."""
    while other != EMPTY:
        j = first + other
        dx, dy = pose[j, 0] - pose[i, 0], pose[j, 1] - pose[i, 1]
        if dx * dx + dy * dy < reach * reach:
            if n_pairs < out_pairs.shape[0]:
                out_pairs[n_pairs, 0] = i
                out_pairs[n_pairs, 1] = j
            n_pairs += 1
        other = following[other]
    return n_pairs


@kernel
def find_pairs(  # noqa: PLR0913 inputs first, then the scratch and the outputs
    pose: Float64[Array, "rows 3"],
    n_robots: int,
    arena: Float64[Array, "2"],
    reach: float,
    head: Int32[Array, "cells_x cells_y"],
    following: Int32[Array, " robots"],
    out_pairs: Int32[Array, "capacity 2"],
    out_start: Int64[Array, " worlds_and_end"],
) -> int:
    """Every pair of rows of one world closer than reach [m], and how many there are.

    Row numbers (i, j), i > j, world by world; those of world w start at out_start[w]. If
    the number exceeds the capacity, the rest is not written: enlarge out_pairs and call again.
    `head` must hold EMPTY everywhere, and does again afterwards.
    """
    cells_x, cells_y = head.shape
    n_pairs = 0
    for w in range(pose.shape[0] // n_robots):
        out_start[w] = n_pairs
        first = w * n_robots
        for r in range(n_robots):
            i = first + r
            cx = cell_of(pose[i, 0], arena[0], reach, cells_x)
            cy = cell_of(pose[i, 1], arena[1], reach, cells_y)
            for kx in range(max(cx - 1, 0), min(cx + 2, cells_x)):
                for ky in range(max(cy - 1, 0), min(cy + 2, cells_y)):
                    n_pairs = note_pairs(
                        pose, i, first, head[kx, ky], reach, following, n_pairs, out_pairs
                    )
            following[r] = head[cx, cy]
            head[cx, cy] = r
        for i in range(first, first + n_robots):
            cx = cell_of(pose[i, 0], arena[0], reach, cells_x)
            cy = cell_of(pose[i, 1], arena[1], reach, cells_y)
            head[cx, cy] = EMPTY
    out_start[-1] = n_pairs
    return n_pairs


@kernel
def push_apart(  # noqa: PLR0913 inputs first, then the outputs
    pairs: Int32[Array, "capacity 2"],
    start: Int64[Array, " worlds_and_end"],
    arena: Float64[Array, "2"],
    radius: float,
    tolerance: float,
    pose: Float64[Array, "rows 3"],
    out_settled: Bool[Array, " worlds"],
) -> None:
    """Move overlapping discs apart and back inside the walls, world by world, in place.

    Each pass moves both discs of an overlapping pair by half the overlap, in a clump by
    more, then every disc inside the walls, until no overlap is over the tolerance [m];
    out_settled says whether MOST_PASSES were enough.
    """
    n_worlds = start.shape[0] - 1
    n_robots = pose.shape[0] // n_worlds
    for w in range(n_worlds):
        out_settled[w] = False
        for n_passes in range(MOST_PASSES):
            keep_inside(pose, w * n_robots, n_robots, arena, radius)
            share = HALF if n_passes < GENTLE_PASSES else OVER_RELAXED
            worst = 0.0
            for k in range(start[w], start[w + 1]):
                i, j = pairs[k, 0], pairs[k, 1]
                worst = max(worst, part(pose, i, j, 2.0 * radius, share))
            if worst <= tolerance:
                out_settled[w] = True
                break
        keep_inside(pose, w * n_robots, n_robots, arena, radius)


@kernel
def keep_inside(
    pose: Float64[Array, "rows 3"],
    first: int,
    n_robots: int,
    arena: Float64[Array, "2"],
    radius: float,
) -> None:
    """Put the discs of one world back inside the walls, in place."""
    far_x, far_y = 0.5 * arena[0] - radius, 0.5 * arena[1] - radius
    for i in range(first, first + n_robots):
        pose[i, 0] = min(max(pose[i, 0], -far_x), far_x)
        pose[i, 1] = min(max(pose[i, 1], -far_y), far_y)


@kernel
def part(pose: Float64[Array, "rows 3"], i: int, j: int, apart: float, share: float) -> float:
    """Move two centres that are less than `apart` [m], each by a share of what they are short [m].

    Two centres in the same place part along x. What they were short is returned.
    """
    dx, dy = pose[j, 0] - pose[i, 0], pose[j, 1] - pose[i, 1]
    d = math.hypot(dx, dy)
    if d >= apart:
        return 0.0
    nx, ny = (dx / d, dy / d) if d > 0.0 else (1.0, 0.0)
    way = share * (apart - d)
    pose[i, 0] -= way * nx
    pose[i, 1] -= way * ny
    pose[j, 0] += way * nx
    pose[j, 1] += way * ny
    return apart - d
