"""Where things go in a picture: a panel above, the arena to scale, a legend below; and bounds."""

from dataclasses import dataclass

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


@dataclass(frozen=True)
class Layout:
    """A picture `width` px wide; the arena lies in the middle and nothing else overlaps it."""

    stage: Stage
    width: int
    beliefs: bool = False
    """There is room below the arena for what a selected robot believes."""
    keys: bool = False
    """There is room for the keys of the window."""

    @property
    def lines(self) -> int:
        """Lines of text below the arena."""
        return self.legend_lines + 2 * self.beliefs + self.keys

    @property
    def legend_lines(self) -> int:
        """Lines of the legend."""
        return 1 if self.stage.goals is None else 2

    @property
    def unit(self) -> float:
        """Everything but the arena is as large as in a picture of 512 px, times this."""
        return min(max(self.width / 512.0, 0.8), 2.0)

    @property
    def margin(self) -> int:
        """Free space at the sides [px]."""
        return round(12 * self.unit)

    @property
    def text(self) -> int:
        """Height of the letters [px]."""
        return round(14 * self.unit)

    @property
    def line(self) -> int:
        """Height of a line of text [px]."""
        return round(20 * self.unit)

    @property
    def header(self) -> int:
        """Height of the panel above the arena [px]."""
        return 2 * self.line + self.margin + round(6 * self.unit)

    @property
    def scale(self) -> float:
        """Pixels in a metre."""
        room = self.width - 2 * self.margin
        return room / max(self.stage.length, self.stage.width)

    @property
    def arena(self) -> tuple[int, int]:
        """Width and height of the arena [px]."""
        stage, scale = self.stage, self.scale
        return round(stage.length * scale), round(stage.width * scale)

    @property
    def corner(self) -> tuple[int, int]:
        """Upper left corner of the arena [px]."""
        return (self.width - self.arena[0]) // 2, self.header

    @property
    def height(self) -> int:
        """Height of the picture [px], an even number."""
        height = self.header + self.arena[1] + self.lines * self.line + self.margin
        return height + height % 2

    @property
    def robot_radius(self) -> float:
        """Radius of a robot as drawn [px]: to scale, unless that is too small to see."""
        return max(self.stage.robot_radius * self.scale, SMALLEST_RADIUS * self.unit)

    @property
    def enlarges(self) -> bool:
        """Robots are drawn larger than they are."""
        return self.robot_radius > self.stage.robot_radius * self.scale

    def pixels(self, places: Float64[Array, "*any 2"]) -> Float64[Array, "*any 2"]:
        """World frame [m] to the arena's own pixels, y down."""
        half = 0.5 * np.array([self.stage.length, self.stage.width])
        return np.asarray((np.asarray(places) * [1.0, -1.0] + half) * self.scale)

    def in_picture(self, places: Float64[Array, "*any 2"]) -> Float64[Array, "*any 2"]:
        """World frame [m] to pixels of the picture."""
        return self.pixels(places) + self.corner
