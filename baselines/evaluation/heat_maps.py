"""Heat maps in panels: shaded tables, robot densities over the arena, and confidence weights."""

from collections.abc import Mapping, Sequence
from functools import partial
from itertools import chain, pairwise
from typing import Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import PowerNorm
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.patches import Circle, Polygon
from matplotlib.ticker import MaxNLocator

from baselines.evaluation.figure_page import (
    LABEL,
    LETTER,
    TICK,
    TITLE,
    Caption,
    CaptionedFigure,
    finish_figure,
    label_panel,
    panel_grid,
    style_in_use,
    wrapped_name,
)
from baselines.evaluation.plot_style import FAINT, INK, colour_of
from baselines.evaluation.statistics import Estimate
from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.scene import Outline, Stage

SHADES = "Blues"  # from white to dark: higher values are darker, also in print
DARK = 0.6  # share of the colour range above which the text of a cell is white
LETTERS, LINE_HEIGHT = 20, 0.127  # letters in a line of a row's name; height of the line [inch]
CONTOURS = (0.1, 0.25, 0.5, 0.75, 0.9)  # weights that have a contour line

MARGIN, STAGGER = 0.08, (0.25, 0.5, 0.75)
"""Share of a map along its frame without labels; positions of the labels along their lines."""

MAP, NARROW, BAR = 2.4, 1.6, 0.8
"""Minimum width of a map of the arena and of weights, and width of a colour bar [inch]."""

LOWEST = 1.9  # of all maps together: the height of the label of a colour bar [inch]

BESIDE = 4  # letters of a line of a title for which the labels of the y axis leave no room

Table = Mapping[str, Mapping[str, Estimate | None]]
"""Means by row and column; None, or no entry, if there is none."""


Density = tuple[Float64[Array, "ys xs"], Stage]
"""Robots per square metre in cells of the arena, mean over time, from the lower left corner on; and
the stage, with the arena and the name of the controller."""


def table_panels(
    tables: Mapping[str, Table], axes_names: tuple[str, str], caption: Caption
) -> Figure:
    """Return a figure of shaded tables of means, one per setup, each with its own colour range."""
    rows = list(dict.fromkeys(chain(*tables.values())))
    cells = chain(*(table.values() for table in tables.values()))
    columns = list(dict.fromkeys(chain(*cells)))
    letters = max(len(word) for name in columns for word in (*name.split(), "10.1 to 10.2"))
    names = [wrapped_name(row, LETTERS) for row in rows]
    margin = max(len(line) for name in names for line in name.split("\n"))
    least = 0.5 + LETTER * TICK * margin + LETTER * TICK * (letters + 1) * len(columns)
    n_lines = max(3, *(name.count("\n") + 1 for name in names))
    figure, all_axes = panel_grid(len(tables), least, 0.9 + LINE_HEIGHT * n_lines * len(rows))
    for axes, (title, table) in zip(all_axes, tables.items(), strict=True):
        _shade(axes, [[table.get(row, {}).get(name) for name in columns] for row in rows])
        axes.set_xticks(range(len(columns)), [name.replace(" ", "\n") for name in columns])
        axes.set_yticks(range(len(rows)), names)
        label_panel(axes, title, axes_names, margin)
        axes.tick_params(length=0.0)
        axes.spines[:].set_visible(False)
    return finish_figure(figure, all_axes, caption)


def _shade(axes: Axes, cells: Sequence[Sequence[Estimate | None]]) -> None:
    means = np.array([[cell.value if cell else np.nan for cell in row] for row in cells])
    top = float(np.max(means[np.isfinite(means)], initial=0.0)) or 1.0
    centres = (np.arange(n) for n in means.shape[::-1])
    axes.pcolormesh(
        *centres, means, cmap=SHADES, vmin=0.0, vmax=1.25 * top, edgecolors="white", linewidth=2.0
    )
    axes.invert_yaxis()
    for (row, column), mean in np.ndenumerate(means):
        cell = cells[row][column]
        dark = mean / (1.25 * top) > DARK
        axes.text(
            column, row, _cell_text(cell), ha="center", va="center",
            fontsize=style_in_use().points(TICK),
            color="white" if dark else INK if cell else FAINT,
        )  # fmt: skip


def _cell_text(cell: Estimate | None) -> str:
    if cell is None:
        return "none"
    top = max(map(abs, (cell.value, *cell.ends)))
    decimals = 0 if top >= 100.0 else 1 if top >= 10.0 else 2
    mean, *ends = (f"{x:.{decimals}f}" for x in (cell.value, *(cell.interval or ())))
    return f"{mean}\n{' to '.join(ends)}" if ends else mean


def density_panels(densities: Mapping[str, Density], caption: Caption) -> Figure:
    """Return a figure of robot densities on one scale, with walls, obstacles and areas."""
    shape = max(stage.width / stage.length for _, stage in densities.values())
    figure, all_axes = _map_grid(len(densities), MAP, shape)
    top = max(float(values.max()) for values, _ in densities.values())
    names: list[str] = []
    for axes, (title, (values, stage)) in zip(all_axes, densities.items(), strict=True):
        x, y = stage.length / 2, stage.width / 2
        image = axes.imshow(
            values, origin="lower", cmap=SHADES, norm=PowerNorm(0.5, 0.0, top),
            extent=(-x, x, -y, y),
        )  # fmt: skip
        names += draw_arena(axes, stage)
        _finish_map(axes, title, stage.controller, ("x [m]", "y [m]"))
    _make_room_for_titles(figure, all_axes, 1)
    _draw_bar(figure, image, all_axes, "robots per m$^2$ (square-root scale)")
    return finish_figure(figure, all_axes, caption, dict.fromkeys(names))


Weights = Mapping[str, Mapping[str, Float64[Array, "heard own"]]]
"""Maps of the weight g by disagreement and by controller."""


def weight_panels(maps: Weights, longest: float, caption: Caption) -> Figure:
    """Return a figure of weights g in [0, 1] over two paths up to `longest` [m], with contours.

    A row for each disagreement, a column for each controller; transposed on a narrow page.
    """
    style, rows, names = style_in_use(), list(maps), list(next(iter(maps.values())))
    is_broad = style.width / len(names) > style.scale * NARROW
    pairs = [(row, name) for row in rows for name in names]
    pairs = pairs if is_broad else [(row, name) for name in names for row in rows]
    columns = len(names) if is_broad else len(rows)
    figure, all_axes = _map_grid(len(pairs), 0.999 * style.width / style.scale / columns, 1.0)
    for axes, (row, name) in zip(all_axes, pairs, strict=True):
        image = axes.imshow(
            maps[row][name], origin="lower", cmap=SHADES, vmin=0.0, vmax=1.0,
            extent=(0.0, longest, 0.0, longest),
        )  # fmt: skip
        paths = np.linspace(0.0, longest, len(maps[row][name]))
        lines = axes.contour(
            paths, paths, maps[row][name], CONTOURS, colors=INK, linewidths=0.8 * style.scale
        )
        places = _label_places(lines.allsegs, longest)
        axes.clabel(lines, fontsize=style.points(TICK - 1.0), fmt="%g", manual=places)
        _finish_map(axes, f"{name}\n{row}", name, ("own path [m]", "heard path [m]"))
    _make_room_for_titles(figure, all_axes, 2)
    words = "g, weight of the heard estimate\n(0 keeps one's own, 1 takes the heard one)"
    _draw_bar(figure, image, all_axes, words)
    return finish_figure(figure, all_axes, caption)


def _map_grid(n_panels: int, least: float, shape: float) -> tuple[CaptionedFigure, list[Axes]]:
    """Return panels for maps of this ratio of height to width, with room for a colour bar."""
    style = style_in_use()
    fitting = max(1, int(style.width / (style.scale * least)))
    rows = -(-n_panels // fitting)
    columns = -(-n_panels // rows)
    bar = 0.0 if style.is_narrow else BAR
    broad = (style.width / style.scale - bar) / columns - 0.45
    figure, panels = panel_grid(n_panels, least, max(broad * shape + 0.55, LOWEST / rows))
    if style.is_narrow:
        figure.set_figheight(figure.get_figheight() + style.scale * BAR)
    return figure, panels


def _label_places(
    lines: Sequence[Sequence[Float64[Array, "points 2"]]], longest: float
) -> list[tuple[float, float]]:
    """Return the place of the label on each contour line: off the frame and the previous label."""
    places = []
    for level, segments in enumerate(lines):
        points = np.concatenate([np.empty((0, 2)), *segments])
        inner = points[np.all(np.abs(points / longest - 0.5) < 0.5 - MARGIN, axis=1)]
        if len(inner):
            x, y = inner[int(len(inner) * STAGGER[level % len(STAGGER)])]
            places.append((float(x), float(y)))
    return places


def _finish_map(axes: Axes, title: str, controller: str, names: tuple[str, str]) -> None:
    axes.spines[:].set(color=colour_of(controller), linewidth=style_in_use().points(2.5))
    label_panel(axes, title, names, BESIDE)
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(nbins=4))


def _make_room_for_titles(figure: Figure, panels: Sequence[Axes], usual: int) -> None:
    """Make a figure higher by the lines of its titles beyond the usual number."""
    lines = [len(axes.get_title("left").split("\n")) for axes in panels]
    columns = panels[0].get_gridspec().ncols  # type: ignore[union-attr]
    rows = [max(lines[k : k + columns]) for k in range(0, len(lines), columns)]
    more = sum(max(0, row - usual) for row in rows)
    figure.set_figheight(figure.get_figheight() + 1.25 * style_in_use().points(TITLE) / 72 * more)


def _draw_bar(figure: Figure, image: AxesImage, panels: Sequence[Axes], words: str) -> None:
    """Draw the labelled colour bar of all panels: at the right, or below on a narrow page."""
    style = style_in_use()
    location: Literal["bottom", "right"] = "bottom" if style.is_narrow else "right"
    bar = figure.colorbar(image, ax=panels, location=location, shrink=0.9, pad=0.02, aspect=30)
    bar.set_label(words, fontsize=style.points(LABEL))
    bar.ax.tick_params(labelsize=style.points(TICK))


BODY = "#CFCFCF"  # colour of obstacles and of the space behind an outer wall

DASHES = ("-", "--", ":", "-.")  # of the outlines of areas, one for each name
ARC = 12  # corners of a half circle


def draw_arena(axes: Axes, stage: Stage) -> list[str]:
    """Draw the walls, obstacles and areas of an arena; return the names of the areas."""
    if len(stage.corners):
        wall = Polygon(stage.corners, fill=False, edgecolor=INK, lw=style_in_use().points(1.0))
        axes.add_patch(wall)
        axes.set_facecolor(BODY)
        for image in axes.images:
            image.set_clip_path(wall)
    for outline in stage.obstacles:
        _draw_obstacle(axes, outline)
    names, width = list(dict.fromkeys(stage.names)), style_in_use().points(1.4)
    dashes = {name: DASHES[number % len(DASHES)] for number, name in enumerate(names)}
    for name in names:
        axes.plot([], [], color=INK, linewidth=width, linestyle=dashes[name], label=name)
    moved = {area: (x, y) for area, _, x, y in stage.moves}
    for area, centre in [*enumerate(stage.areas), *moved.items()]:
        circle = partial(Circle, tuple(centre), stage.area_radius, fill=False)
        axes.add_patch(circle(color="white", lw=2.4 * width))
        axes.add_patch(circle(color=INK, lw=width, ls=dashes[stage.names[area]]))
    axes.set_xlim(-stage.length / 2, stage.length / 2)
    axes.set_ylim(-stage.width / 2, stage.width / 2)
    return names


def _draw_obstacle(axes: Axes, outline: Outline) -> None:
    points = outline.points
    if outline.is_closed:
        axes.add_patch(Polygon(points, facecolor=BODY, edgecolor=INK, lw=0.8))
        points = np.concatenate([points, points[:1]])
    for start, end in pairwise(points) if len(points) > 1 else [(points[0], points[0])]:
        wall = capsule(start, end, outline.radius)
        axes.add_patch(Polygon(wall, facecolor=BODY, edgecolor=INK, lw=0.8))


def capsule(
    start: Float64[Array, " 2"], end: Float64[Array, " 2"], radius: float
) -> Float64[Array, "corners 2"]:
    """Return the outline of a wall with round ends, or of a disc if both ends are the same [m]."""
    heading = np.arctan2(*(end - start)[::-1])
    turn = np.linspace(-np.pi / 2, np.pi / 2, ARC)
    arcs = [
        at + radius * np.stack([np.cos(turn + angle), np.sin(turn + angle)], axis=1)
        for at, angle in ((end, heading), (start, heading + np.pi))
    ]
    return np.concatenate(arcs)
