"""Shapes, drawn enlarged: scaling the picture down smooths their edges."""

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import pygame

from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.rendering import palette
from swarm_forage_env.rendering.palette import Colour
from swarm_forage_env.scene import EXPLORING

Point = Sequence[float] | Float64[Array, " 2"]
"""Position on a surface [px]."""


def draw_robot(
    surface: pygame.Surface, at: Point, heading: float, activity: int, size: tuple[float, float]
) -> None:
    """Draw a robot as a disc in the colour of its state, with a wedge that points ahead.

    `size` is the radius and the thickness of the rim [px]; the rim takes at most a fifth of the
    radius.
    """
    radius, rim = size[0], min(size[1], 0.2 * size[0])
    c, s = math.cos(heading), -math.sin(heading)
    pygame.draw.circle(surface, palette.INK, at, radius)
    pygame.draw.circle(surface, palette.ROBOT[activity], at, radius - rim)
    ink = palette.INK if activity == EXPLORING else palette.WHITE
    wedge = [(0.78, 0.0), (-0.1, 0.5), (-0.1, -0.5)]
    corners = [
        (at[0] + radius * (c * ahead - s * side), at[1] + radius * (s * ahead + c * side))
        for ahead, side in wedge
    ]
    pygame.draw.polygon(surface, ink, corners)


def draw_cross(surface: pygame.Surface, colour: Colour, at: Point, arm: float, width: int) -> None:
    """Draw a diagonal cross; `arm` is half of its side length [px]."""
    x, y = at
    for side in (-arm, arm):
        pygame.draw.line(surface, colour, (x - arm, y - side), (x + arm, y + side), width)


def draw_fault_mark(surface: pygame.Surface, at: Point, radius: float, width: int) -> None:
    """Draw a red cross over a faulty robot, as large as its body [px]."""
    draw_cross(surface, palette.WHITE, at, 0.85 * radius, 2 * width)
    draw_cross(surface, palette.FAULTY, at, 0.85 * radius, width)


def draw_belief(
    surface: pygame.Surface,
    centre: Float64[Array, " 2"],
    radii: tuple[float, float],
    colour: Colour,
    pixel: float,
) -> None:
    """Draw a believed area: a dashed circle, a cross at its centre, and a ring that shows p."""
    area, ring = radii
    width = max(1, round(1.5 * pixel))
    pygame.draw.circle(surface, colour, centre, ring, width)
    dashed_circle(surface, colour, centre, area, (width, 4.0 * pixel))
    x, y = centre.tolist()
    arm = 3.5 * pixel
    pygame.draw.line(surface, palette.INK, (x - arm, y), (x + arm, y), width)
    pygame.draw.line(surface, palette.INK, (x, y - arm), (x, y + arm), width)


def draw_arc(
    surface: pygame.Surface,
    sender: Float64[Array, " 2"],
    receiver: Float64[Array, " 2"],
    width: int,
) -> None:
    """Draw a message as an arc that bends to the left; thus two directions do not overlap."""
    share = np.linspace(0.0, 1.0, 17)[:, None]
    bow = 0.35 * np.array([receiver[1] - sender[1], sender[0] - receiver[0]])
    arc = (1.0 - share) * sender + share * receiver + 4.0 * share * (1.0 - share) * bow
    pygame.draw.lines(surface, palette.MESSAGE, False, arc.tolist(), width)


def draw_walls(
    surface: pygame.Surface, points: list[list[float]], radius: float, is_closed: bool
) -> None:
    """Draw an obstacle: a disc, walls with round ends, or a filled polygon of walls.

    Points and radius, half the thickness, are in pixels; thin walls are drawn three pixels wide.
    """
    ends, width = [*points, points[0]] if is_closed else points, max(radius, 1.5)
    if is_closed:
        pygame.draw.polygon(surface, palette.WALL, points)
    for place in ends:
        pygame.draw.circle(surface, palette.WALL, place, width)
    for (ax, ay), (bx, by) in pairwise(ends):
        share = width / max(math.hypot(bx - ax, by - ay), 1e-9)
        nx, ny = share * (ay - by), share * (bx - ax)
        side = [(ax + nx, ay + ny), (bx + nx, by + ny), (bx - nx, by - ny), (ax - nx, ay - ny)]
        pygame.draw.polygon(surface, palette.WALL, side)


def dashed_circle(
    surface: pygame.Surface,
    colour: Colour,
    centre: Float64[Array, " 2"],
    radius: float,
    stroke: tuple[int, float],
) -> None:
    """Draw a circle of dashes, as long as the gaps; `stroke` is their width and length [px]."""
    width, dash = stroke
    n = max(6, round(math.pi * radius / dash))
    for k in range(n):
        angle = np.linspace(2 * k, 2 * k + 1, 6) * math.pi / n
        arc = np.stack([np.cos(angle), np.sin(angle)], axis=1) * radius + centre
        pygame.draw.lines(surface, colour, False, arc.tolist(), width)


def draw_goal(surface: pygame.Surface, at: Point, radius: float, pixel: float) -> None:
    """Draw a goal: the circle in which it is reached, with a point in its middle [px]."""
    pygame.draw.circle(surface, palette.GOAL, at, radius, max(1, round(1.5 * pixel)))
    pygame.draw.circle(surface, palette.GOAL, at, 1.6 * pixel)


def draw_right(surface: pygame.Surface, at: Point, size: float) -> None:
    """Draw a right claim: a disc with a tick [px]."""
    pygame.draw.circle(surface, palette.RIGHT, at, size)
    tick = [(-0.5, 0.05), (-0.1, 0.45), (0.55, -0.4)]
    points = [(at[0] + size * a, at[1] + size * b) for a, b in tick]
    pygame.draw.lines(surface, palette.WHITE, False, points, max(1, round(0.28 * size)))


def draw_wrong(surface: pygame.Surface, at: Point, size: float) -> None:
    """Draw a wrong claim: a cross [px]."""
    draw_cross(surface, palette.WRONG, at, 0.8 * size, max(2, round(0.45 * size)))


def draw_ellipse(
    surface: pygame.Surface, centre: Point, axes: tuple[float, float], direction: float, width: int
) -> None:
    """Draw an ellipse of half axes `axes` [px], the first in `direction`, world frame [rad]."""
    angle = np.linspace(0.0, 2.0 * np.pi, 49)
    along, across = axes[0] * np.cos(angle), axes[1] * np.sin(angle)
    c, s = np.cos(direction), np.sin(direction)
    points = centre + np.stack([c * along - s * across, -s * along - c * across], axis=1)
    pygame.draw.lines(surface, palette.ESTIMATE, True, points.tolist(), width)
    pygame.draw.circle(surface, palette.ESTIMATE, centre, 1.2 * width)
