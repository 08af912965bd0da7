"""The floor: which area holds a point, and how bright it is there."""

from swarm_forage_env.arrays import NEST, PREY, Array, Float64
from swarm_forage_env.compiler import kernel

BLACK, GREY, WHITE = 0.0, 0.5, 1.0
"""Brightness of the nest, the prey area and the rest of the floor (TR 5)."""

FLOOR = -1
"""Stands on neither area."""


@kernel
def is_within(
    x: float, y: float, areas: Float64[Array, "areas 2"], area: int, radius: float
) -> bool:
    """The point (x, y) lies in an area of that radius [m]."""
    dx, dy = x - areas[area, 0], y - areas[area, 1]
    return bool(dx * dx + dy * dy <= radius * radius)


@kernel
def area_at(
    x: float, y: float, areas: Float64[Array, "areas 2"], n_areas: int, radius: float
) -> int:
    """Which of the first n >= 2 areas holds the point (x, y) [m]: its number, or FLOOR."""
    for area in range(2):  # that many are there nearly always: a compiler unrolls the loop
        if is_within(x, y, areas, area, radius):
            return area
    for area in range(2, n_areas):
        if is_within(x, y, areas, area, radius):
            return area
    return FLOOR


@kernel
def brightness(area: int) -> float:
    """How bright the floor is in an area: nest black, prey grey, the rest white.

    Source: TR, Section 5.
    """
    if area == NEST:
        return BLACK
    return GREY if area == PREY else WHITE
