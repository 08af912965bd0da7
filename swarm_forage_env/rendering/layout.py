"""Layout of a picture: a panel above, the arena to scale, a legend below; bounds of its options."""

import numpy as np

from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.scene import Stage

SMALLEST, LARGEST = 400, 3840
"""Bounds of the width of a picture [px]; text does not fit into smaller ones."""

SPEEDS = (0.1, 256.0)
"""Bounds of the speed, as a multiple of real time."""

SMALLEST_RADIUS = 3.2
"""Smallest radius of a drawn robot, in a picture 512 px wide [px]."""

P_RING = 0.1
"""Share of p by which the ring around a believed area is wider than the area."""


def checked_size(size: int) -> int:
    """Return a width rounded down to an even number; ConfigError if it is out of bounds."""
    if not SMALLEST <= size <= LARGEST:
        raise ConfigError(f"size={size}: must be {SMALLEST} to {LARGEST} [px]")
    return size - size % 2  # videos need even sizes


def checked_speed(speed: float) -> float:
    """Return the speed, a multiple of real time; ConfigError if it is out of bounds."""
    slowest, fastest = SPEEDS
    if not slowest <= speed <= fastest:
        raise ConfigError(f"speed={speed:g}: must be {slowest:g} to {fastest:g} times real time")
    return speed


class Layout:
    """Layout of a picture `width` px wide, with nothing overlapping the arena in its middle.

    Sizes are in pixels. Below the arena, `beliefs` reserves lines for the beliefs of the selected
    robot, `keys` one for the keys of the window.
    """

    def __init__(self, stage: Stage, width: int, beliefs: bool = False, keys: bool = False) -> None:
        self.stage, self.beliefs, self.keys = stage, beliefs, keys
        self.width = width = checked_size(width)
        self.unit = min(max(width / 512.0, 0.8), 2.0)
        """Scale of everything but the arena, relative to a picture 512 px wide."""
        self.margin, self.text, self.line = (round(size * self.unit) for size in (12, 14, 20))
        """Margin at the sides, font size and height of a line of text."""
        self.scale = (width - 2 * self.margin) / max(stage.length, stage.width)
        """Pixels per metre."""
        self.arena = round(stage.length * self.scale), round(stage.width * self.scale)
        header = 2 * self.line + self.margin + round(6 * self.unit)
        self.corner = (width - self.arena[0]) // 2, header
        """Upper left corner of the arena, below the panel."""
        self.legend_lines = 1 if stage.goals is None else 2
        n_lines = self.legend_lines + (1 + stage.believes) * beliefs + keys
        height = header + self.arena[1] + n_lines * self.line + self.margin
        self.height = height + height % 2  # videos need even sizes
        self.robot_radius = max(stage.robot_radius * self.scale, SMALLEST_RADIUS * self.unit)
        """Radius of a drawn robot: to scale, unless that is below SMALLEST_RADIUS."""
        self.enlarges = self.robot_radius > stage.robot_radius * self.scale

    def pixels(self, places: Float64[Array, "*any 2"]) -> Float64[Array, "*any 2"]:
        """Convert the world frame [m] to pixels of the arena, y down."""
        half = 0.5 * np.array([self.stage.length, self.stage.width])
        return np.asarray((np.asarray(places) * [1.0, -1.0] + half) * self.scale)

    def in_picture(self, places: Float64[Array, "*any 2"]) -> Float64[Array, "*any 2"]:
        """Convert the world frame [m] to pixels of the picture."""
        return self.pixels(places) + self.corner
