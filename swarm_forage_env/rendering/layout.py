"""Where things go in a picture: a panel above, the arena to scale, a legend below; and bounds."""

import numpy as np

from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.scene import Stage

SMALLEST, LARGEST = 400, 3840
"""Width of a picture [px]: below, the words do not fit."""

SPEEDS = (0.1, 256.0)
"""Slowest and fastest multiple of real time."""

SMALLEST_RADIUS = 3.2
"""A robot is drawn at least this large, in a picture 512 px wide [px]."""

P_RING = 0.1
"""Around a believed place lies a ring, wider than the area by this share of p."""


def checked_size(size: int) -> int:
    """The width of a picture; ConfigError for one that is too small or too large."""
    if not SMALLEST <= size <= LARGEST:
        raise ConfigError(f"size={size}: must be {SMALLEST} to {LARGEST} [px]")
    return size - size % 2  # videos want even numbers


def checked_speed(speed: float) -> float:
    """A multiple of real time; ConfigError for one out of bounds."""
    slowest, fastest = SPEEDS
    if not slowest <= speed <= fastest:
        raise ConfigError(f"speed={speed:g}: must be {slowest:g} to {fastest:g} times real time")
    return speed


class Layout:
    """A picture `width` px wide; the arena lies in the middle and nothing else overlaps it.

    Sizes are in pixels. With `beliefs` there is room below the arena for what a selected robot
    believes, with `keys` for the keys of the window.
    """

    def __init__(self, stage: Stage, width: int, beliefs: bool = False, keys: bool = False) -> None:
        self.stage, self.beliefs, self.keys = stage, beliefs, keys
        self.width = width = checked_size(width)
        self.unit = min(max(width / 512.0, 0.8), 2.0)
        """Everything but the arena is as large as in a picture of 512 px, times this."""
        self.margin, self.text, self.line = (round(size * self.unit) for size in (12, 14, 20))
        """Free space at the sides, and the heights of letters and of a line of text."""
        self.scale = (width - 2 * self.margin) / max(stage.length, stage.width)
        """Pixels in a metre."""
        self.arena = round(stage.length * self.scale), round(stage.width * self.scale)
        header = 2 * self.line + self.margin + round(6 * self.unit)
        self.corner = (width - self.arena[0]) // 2, header
        """Upper left corner of the arena, below the panel."""
        self.legend_lines = 1 if stage.goals is None else 2
        n_lines = self.legend_lines + 2 * beliefs + keys
        height = header + self.arena[1] + n_lines * self.line + self.margin
        self.height = height + height % 2  # videos want even numbers
        self.robot_radius = max(stage.robot_radius * self.scale, SMALLEST_RADIUS * self.unit)
        """Radius of a robot as drawn: to scale, unless that is too small to see."""
        self.enlarges = self.robot_radius > stage.robot_radius * self.scale

    def pixels(self, places: Float64[Array, "*any 2"]) -> Float64[Array, "*any 2"]:
        """World frame [m] to the arena's own pixels, y down."""
        half = 0.5 * np.array([self.stage.length, self.stage.width])
        return np.asarray((np.asarray(places) * [1.0, -1.0] + half) * self.scale)

    def in_picture(self, places: Float64[Array, "*any 2"]) -> Float64[Array, "*any 2"]:
        """World frame [m] to pixels of the picture."""
        return self.pixels(places) + self.corner
