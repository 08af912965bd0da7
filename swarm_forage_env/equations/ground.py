"""The floor: the area at a point, and its brightness."""

from swarm_forage_env.arrays import NEST, PREY, Array, Float64
from swarm_forage_env.compiler import kernel

BLACK, GREY, WHITE = 0.0, 0.5, 1.0
"""Brightness of the nest, the prey area and the rest of the floor (TR 5; grey: chosen)."""

FLOOR = -1
"""Index for a point in no area."""


@kernel
def is_within(
    x: float, y: float, areas: Float64[Array, "areas 2"], area: int, radius: float
) -> bool:
    """Return whether the point (x, y) is within `radius` of the centre of an area [m]."""
    dx, dy = x - areas[area, 0], y - areas[area, 1]
    return bool(dx * dx + dy * dy <= radius * radius)


@kernel
def area_at(
    x: float, y: float, areas: Float64[Array, "areas 2"], n_areas: int, radius: float
) -> int:
    """Return the index of the first of n >= 2 areas that contains (x, y) [m], or FLOOR."""
    for area in range(2):  # nearly always all there are; the compiler unrolls this loop
        if is_within(x, y, areas, area, radius):
            return area
    for area in range(2, n_areas):
        if is_within(x, y, areas, area, radius):
            return area
    return FLOOR


@kernel
def brightness(area: int) -> float:
    """Return the brightness of the floor in an area: nest black, prey grey, the rest white.

    Source: TR, Section 5.
    """
    if area == NEST:
        return BLACK
    return GREY if area == PREY else WHITE
