"""The floor and the three sensors that look at it."""

from swarm_forage_env.arrays import NEST, PREY, Array, Float32, Float64, UInt64
from swarm_forage_env.kernels.compiler import kernel
from swarm_forage_env.kernels.frames import to_outer
from swarm_forage_env.kernels.rng import symmetric

BLACK, GREY, WHITE = 0.0, 0.5, 1.0
"""Brightness of the nest, the prey area and the rest of the floor (TR 5)."""

FLOOR = -1
"""Stands on neither area."""


@kernel
def area_at(x: float, y: float, areas: Float64[Array, "areas 2"], radius: float) -> int:
    """Which area holds the point (x, y) of the world frame [m]: NEST, PREY or FLOOR."""
    for area in range(2):
        dx, dy = x - areas[area, 0], y - areas[area, 1]
        if dx * dx + dy * dy <= radius * radius:
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


@kernel
def read_ground(  # noqa: PLR0913 inputs first, then the output
    pose: Float64[Array, "rows 3"],
    areas: Float64[Array, "areas 2"],
    radius: float,
    ahead: float,
    spacing: float,
    noise: float,
    streams: UInt64[Array, " rows"],
    out_reading: Float32[Array, "rows 3"],
) -> None:
    """Brightness times 1 +- noise under the left, middle and right sensor."""
    for i in range(pose.shape[0]):
        for sensor in range(3):
            dx, dy = to_outer(ahead, (1 - sensor) * spacing, pose[i, 2])
            light = brightness(area_at(pose[i, 0] + dx, pose[i, 1] + dy, areas, radius))
            if light > 0.0:
                light *= 1.0 + noise * symmetric(streams, i)
            out_reading[i, sensor] = light
