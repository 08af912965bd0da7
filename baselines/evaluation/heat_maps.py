"""Heat maps in panels: shaded tables, robot densities, and confidence weights."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import PowerNorm
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Rectangle

from baselines.evaluation.plot_style import (
    FAINT,
    INK,
    LETTER_WIDTH,
    draw_caption,
    draw_frame,
    label_panel,
    panel_grid,
)
from baselines.evaluation.statistics import Estimate
from swarm_forage_env.arrays import Array, Float64

SHADES = "Blues"
"""From white to dark: in print too, more is darker."""

DARK = 0.6
"""Share of the range from which a cell is so dark that its text is white."""

CONTOURS = (0.1, 0.25, 0.5, 0.75, 0.9)
"""Weights that have a line on their map."""

Table = Mapping[str, Mapping[str, Estimate | None]]
"""Means by row and column; None, or left out, where there is none."""


@dataclass(frozen=True)
class Density:
    """Robots per square metre in cells of the arena, mean over time."""

    values: Float64[Array, "ys xs"]
    """[1/m^2], from the lower left corner."""
    size: tuple[float, float]
    """Length and width of the arena [m], its centre at the origin."""
    areas: Mapping[str, tuple[float, float]]
    """Centre of each area [m]."""
    area_radius: float
    """[m]."""
    controller: str
    """By its name."""


def table_panels(tables: Mapping[str, Table], axes_names: tuple[str, str], text: str) -> Figure:
    """A figure of shaded tables of means, a panel for each setup with a range of its own."""
    rows = list(dict.fromkeys(row for table in tables.values() for row in table))
    columns = list(
        dict.fromkeys(name for table in tables.values() for row in table.values() for name in row)
    )
    margin = 0.9 + LETTER_WIDTH * max(map(len, rows))
    letters = max(len(word) for name in columns for word in name.split())
    width = max(1.15, LETTER_WIDTH * letters)
    figure, all_axes = panel_grid(len(tables), margin + width * len(columns))
    for axes, (title, table) in zip(all_axes, tables.items(), strict=True):
        _shade(axes, [[table.get(row, {}).get(name) for name in columns] for row in rows])
        axes.set_xticks(range(len(columns)), [name.replace(" ", "\n") for name in columns])
        axes.set_yticks(range(len(rows)), rows)
        label_panel(axes, title, axes_names)
        axes.tick_params(length=0.0)
        axes.spines[:].set_visible(False)
    draw_caption(figure, text)
    return figure


def _shade(axes: Axes, cells: Sequence[Sequence[Estimate | None]]) -> None:
    means = np.array([[cell.value if cell else np.nan for cell in row] for row in cells])
    top = float(np.nanmax(means)) or 1.0
    axes.imshow(means, cmap=SHADES, vmin=0.0, vmax=1.25 * top, aspect="auto")
    for (row, column), mean in np.ndenumerate(means):
        cell = cells[row][column]
        dark = mean / (1.25 * top) > DARK
        axes.text(
            column, row, _cell_text(cell), ha="center", va="center", fontsize=8.5,
            color="white" if dark else INK if cell else FAINT,
        )  # fmt: skip
    axes.set_xticks(np.arange(means.shape[1] + 1) - 0.5, minor=True)
    axes.set_yticks(np.arange(means.shape[0] + 1) - 0.5, minor=True)
    axes.grid(which="minor", color="white", linewidth=2.0)
    axes.tick_params(which="minor", length=0.0)


def _cell_text(cell: Estimate | None) -> str:
    """A cell's text: the mean over its interval."""
    if cell is None:
        return "none"
    top = max(abs(cell.value), *map(abs, cell.interval or (0.0, 0.0)))
    decimals = 0 if top >= 100.0 else 1 if top >= 10.0 else 2
    mean = f"{cell.value:.{decimals}f}"
    if cell.interval is None:
        return mean
    low, high = cell.interval
    return f"{mean}\n{low:.{decimals}f} to {high:.{decimals}f}"


def density_panels(densities: Mapping[str, Density], text: str) -> Figure:
    """A figure of robot densities on one scale, with the areas marked."""
    figure, all_axes = panel_grid(len(densities), 4.6)
    rows = all_axes[0].get_gridspec().nrows  # type: ignore[union-attr]
    shape = max(density.size[1] / density.size[0] for density in densities.values())
    figure.set_figheight(rows * (3.5 * shape + 1.0) + 0.5)
    top = max(float(density.values.max()) for density in densities.values())
    for axes, (title, density) in zip(all_axes, densities.items(), strict=True):
        length, width = density.size
        image = axes.imshow(
            density.values, origin="lower", cmap=SHADES, norm=PowerNorm(0.5, 0.0, top),
            extent=(-length / 2, length / 2, -width / 2, width / 2),
        )  # fmt: skip
        _draw_arena(axes, density)
        draw_frame(axes, density.controller)
        label_panel(axes, title, ("x [m]", "y [m]"))
    bar = figure.colorbar(image, ax=all_axes, shrink=0.85, pad=0.02)
    bar.set_label("robots per m$^2$ (square-root scale)")
    bar.ax.tick_params(labelsize=8.5)
    draw_caption(figure, text)
    return figure


def weight_panels(
    maps: Mapping[str, Float64[Array, "heard own"]], longest: float, columns: int, text: str
) -> Figure:
    """A figure of weights g in [0, 1] over two paths up to the longest [m], with contours."""
    figure = Figure(
        figsize=(max(5.0, 3.1 * columns + 0.8), 3.1 * len(maps) / columns + 0.9),
        layout="constrained",
    )
    all_axes = figure.subplots(len(maps) // columns, columns, squeeze=False).flat
    for axes, (title, weights) in zip(all_axes, maps.items(), strict=True):
        extent = (0.0, longest, 0.0, longest)
        image = axes.imshow(weights, origin="lower", cmap=SHADES, vmin=0.0, vmax=1.0, extent=extent)
        paths = np.linspace(0.0, longest, len(weights))
        lines = axes.contour(paths, paths, weights, CONTOURS, colors=INK, linewidths=0.9)
        axes.clabel(lines, fontsize=7.5, fmt="%g")
        draw_frame(axes, title.partition("\n")[0])
        label_panel(axes, title, ("own path since the area [m]", "heard path [m]"))
    bar = figure.colorbar(image, ax=list(figure.axes), shrink=0.85, pad=0.02)
    bar.set_label("g")
    draw_caption(figure, text)
    return figure


def _draw_arena(axes: Axes, density: Density) -> None:
    """Draw the walls, and the areas with their names above them."""
    length, width = density.size
    axes.add_patch(
        Rectangle((-length / 2, -width / 2), length, width, fill=False, color=INK, lw=1.2)
    )
    for dashes, (name, (x, y)) in zip(("-", "--"), density.areas.items(), strict=True):
        axes.add_patch(
            Circle((x, y), density.area_radius, fill=False, color="#D55E00", lw=1.8, ls=dashes)
        )
        axes.annotate(
            name, (x, y + density.area_radius), xytext=(0, 3), textcoords="offset points",
            ha="center", va="bottom", fontsize=9, color=INK,
            bbox={"facecolor": "white", "alpha": 0.75, "edgecolor": "none", "pad": 1.0},
        )  # fmt: skip
    axes.set_xlim(-length / 2, length / 2)
    axes.set_ylim(-width / 2, width / 2)
