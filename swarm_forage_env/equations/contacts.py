"""Resolution of contacts: separate overlapping discs and keep them inside the walls."""

from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.compiler import kernel
from swarm_forage_env.equations.elementary import hypot
from swarm_forage_env.equations.geometry import Pose

MAX_PASSES = 2000
GENTLE_PASSES = 20
"""Number of passes with HALF; then OVER_RELAXED settles the remaining clumps 3 times sooner."""
HALF, OVER_RELAXED = 0.5, 0.9
"""Share of an overlap by which each of the two discs moves."""

OVERLAP = 1e-4
"""Overlap of two bodies that may remain after contacts are resolved [m]."""

_ROUNDING = 1.0 + 1e-12


@kernel
def keep_inside(pose: Pose, arena: Float64[Array, "2"], radius: float) -> None:
    """Move a disc back inside the walls of an arena with these side lengths [m], in place."""
    far_x, far_y = 0.5 * arena[0] - radius, 0.5 * arena[1] - radius
    pose[0] = min(max(pose[0], -far_x), far_x)
    pose[1] = min(max(pose[1], -far_y), far_y)


@kernel
def separate_pair(a: Pose, b: Pose, apart: float, share: float) -> float:
    """Separate two centres closer than `apart` [m]: move each by a share of the missing distance.

    Two centres at the same point separate along x. Returns the distance that was missing [m].
    """
    dx, dy = b[0] - a[0], b[1] - a[1]
    if dx * dx + dy * dy > apart * apart * _ROUNDING:
        return 0.0
    d = hypot(dx, dy)
    if d >= apart:
        return 0.0
    nx, ny = (dx / d, dy / d) if d > 0.0 else (1.0, 0.0)
    way = share * (apart - d)
    a[0] -= way * nx
    a[1] -= way * ny
    b[0] += way * nx
    b[1] += way * ny
    return apart - d
