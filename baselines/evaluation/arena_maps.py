"""An arena on a map: its walls and obstacles, the nest and the prey area, before they are moved."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Polygon

from baselines.evaluation.figure_page import style_in_use
from baselines.evaluation.plot_style import INK
from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.scene import Outline, Stage

BODY = "#CFCFCF"
"""Colour of obstacles, and of what lies behind an outer wall."""

DASHES = ("-", "--", ":", "-.")
"""Outlines of areas, one for each name that there is."""

ARC = 12
"""Corners of half a circle."""


def draw_arena(axes: Axes, stage: Stage) -> list[str]:
    """Draw what stands in an arena; return the names of its areas, which a legend explains.

    No name stands on the map, where it would hide robots.
    """
    if len(stage.corners):
        _draw_outside(axes, stage)
    for outline in stage.obstacles:
        _draw_obstacle(axes, outline)
    names = list(dict.fromkeys(stage.names))
    moved = {area: (x, y) for area, _, x, y in stage.moves}
    for area, (name, centre) in enumerate(zip(stage.names, stage.areas, strict=True)):
        dashes = DASHES[names.index(name) % len(DASHES)]
        is_first = stage.names.index(name) == area
        _draw_area(axes, centre, stage.area_radius, dashes, name if is_first else "")
        if area in moved:
            _draw_area(axes, np.array(moved[area]), stage.area_radius, dashes, "")
    axes.set_xlim(-stage.length / 2, stage.length / 2)
    axes.set_ylim(-stage.width / 2, stage.width / 2)
    return names


def _draw_area(
    axes: Axes, centre: Float64[Array, " 2"], radius: float, dashes: str, name: str
) -> None:
    """Draw a circle that is seen on light and on dark."""
    width = style_in_use().points(1.4)
    x, y = map(float, centre)
    axes.add_patch(Circle((x, y), radius, fill=False, color="white", lw=2.4 * width))
    axes.add_patch(Circle((x, y), radius, fill=False, color=INK, lw=width, ls=dashes))
    if name:
        axes.plot([], [], color=INK, linewidth=width, linestyle=dashes, label=name)


def _draw_outside(axes: Axes, stage: Stage) -> None:
    """Fill the rectangle around an outer wall of another shape."""
    x, y = stage.length / 2, stage.width / 2
    corners, ahead = stage.corners, np.roll(stage.corners, -1, axis=0)
    area = float(np.sum(corners[:, 0] * ahead[:, 1] - ahead[:, 0] * corners[:, 1]))
    inner = corners if area < 0.0 else corners[::-1]  # the other way round: a hole
    around = np.array([(-x, -y), (x, -y), (x, y), (-x, y), (-x, -y)])
    points = np.concatenate([around, inner, inner[:1], around[:1]])
    axes.add_patch(Polygon(points, facecolor=BODY, edgecolor="none"))
    axes.add_patch(Polygon(corners, fill=False, edgecolor=INK, lw=style_in_use().points(1.0)))


def _draw_obstacle(axes: Axes, outline: Outline) -> None:
    """Draw a disc, walls, or a filled polygon with its walls."""
    points = outline.points
    if outline.is_closed:
        axes.add_patch(Polygon(points, facecolor=BODY, edgecolor=INK, lw=0.8))
    ends = np.roll(points, -1, axis=0) if outline.is_closed else points[1:]
    starts = points if outline.is_closed or len(points) == 1 else points[:-1]
    for start, end in zip(starts, ends if len(points) > 1 else starts, strict=True):
        wall = capsule(start, end, outline.radius)
        axes.add_patch(Polygon(wall, facecolor=BODY, edgecolor=INK, lw=0.8))


def capsule(
    start: Float64[Array, " 2"], end: Float64[Array, " 2"], radius: float
) -> Float64[Array, "corners 2"]:
    """The outline of a wall with round ends; of a disc, where both ends are the same [m]."""
    heading = np.arctan2(*(end - start)[::-1])
    turn = np.linspace(-np.pi / 2, np.pi / 2, ARC)
    arcs = [
        at + radius * np.stack([np.cos(turn + angle), np.sin(turn + angle)], axis=1)
        for at, angle in ((end, heading), (start, heading + np.pi))
    ]
    return np.concatenate(arcs)
