"""Figures of several panels: groups of boxes, and curves with their bands."""

import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from baselines.evaluation.plots import FAINT, INK, LETTER_WIDTH, PALETTE
from baselines.evaluation.statistics import CONFIDENCE
from swarm_forage_env.arrays import Array, Float64

Groups = Mapping[str, Mapping[str, Sequence[float]]]
"""Samples by tick of the axis and by series; ticks stand apart, the series of a tick together."""

SIDE_BY_SIDE = 8
"""Most boxes in a panel that still has others beside it; larger panels stand below each other."""

BOX, MARGIN, HEIGHT = 0.62, 1.1, 3.3
"""Width of a box with its distance, margin and height of a panel [inch]."""

LINES = tuple(colour for colour in PALETTE if colour != "#F0E442")
"""Colours of curves; a yellow line is lost on white."""

RESAMPLES = 1000
"""Drawn for a band."""


@dataclass(frozen=True)
class Curve:
    """A value over x for each episode."""

    x: Float64[Array, " points"]
    y: Float64[Array, "episodes points"]


def box_panels(panels: Mapping[str, Groups], axes_names: tuple[str, str], caption: str) -> Figure:
    """A panel of boxes for each setup; the axes are named x, y."""
    largest = max(sum(map(len, groups.values())) for groups in panels.values())
    stacked = largest > SIDE_BY_SIDE
    letters = max(
        len(line) for ticks in panels.values() for tick in ticks for line in tick.split("\n")
    )
    box = max(BOX, LETTER_WIDTH * letters)
    figure, all_axes = _frame(len(panels), stacked, MARGIN + box * max(largest, 4))
    for axes, (title, groups) in zip(all_axes, panels.items(), strict=True):
        _draw_groups(axes, groups)
        _finish(axes, title, axes_names)
    _legend(figure, all_axes[0])
    _caption(figure, caption)
    return figure


def curve_panels(
    panels: Mapping[str, Mapping[str, Curve]], axes_names: tuple[str, str], caption: str
) -> Figure:
    """A panel of mean curves with 95 % bootstrap bands for each setup; the axes are named x, y."""
    figure, all_axes = _frame(len(panels), len(panels) > 3, 4.2)
    for axes, (title, curves) in zip(all_axes, panels.items(), strict=True):
        for number, (name, curve) in enumerate(curves.items()):
            _draw_curve(axes, name, curve, LINES[number % len(LINES)])
        axes.set_xlim(left=0.0)
        _finish(axes, title, axes_names)
    _legend(figure, all_axes[0])
    _caption(figure, caption)
    return figure


@dataclass(frozen=True)
class ErrorBars:
    """Mean and standard deviation over x, and published means; NaN where there is none."""

    x: Float64[Array, " points"]
    mean: Float64[Array, " points"]
    sd: Float64[Array, " points"]
    published: Float64[Array, " points"]


def error_panels(
    panels: Mapping[str, Mapping[str, ErrorBars]], axes_names: tuple[str, str], caption: str
) -> Figure:
    """A panel of means with bars of one standard deviation for each setup; one y for all."""
    figure, all_axes = _frame(len(panels), len(panels) > 3, 3.6)
    highest = max(
        float(np.nanmax(bars.mean + bars.sd)) for each in panels.values() for bars in each.values()
    )
    for axes, (title, series) in zip(all_axes, panels.items(), strict=True):
        span = max(float(np.ptp(bars.x)) for bars in series.values())
        for number, (name, bars) in enumerate(series.items()):
            colour, shift = LINES[number % len(LINES)], 0.012 * span * (number - 1)
            axes.errorbar(
                bars.x + shift, bars.mean, bars.sd, color=colour, label=name,
                marker="o", markersize=4.0, linewidth=1.6, capsize=3.0,
            )  # fmt: skip
            axes.plot(bars.x + shift, bars.published, "x", color=INK, markersize=6.0, zorder=5)
        axes.set_xlim(left=0.0)
        _finish(axes, title, axes_names)
        axes.set_ylim(0.0, 1.05 * highest)
    _legend(figure, all_axes[0])
    _caption(figure, caption)
    return figure


def band(values: Float64[Array, "episodes points"]) -> Float64[Array, "2 points"]:
    """The 95 % bootstrap interval of the mean at each point (percentiles)."""
    n_episodes = len(values)
    draws = np.random.default_rng(0).integers(n_episodes, size=(RESAMPLES, n_episodes))
    weights = np.stack([np.bincount(draw, minlength=n_episodes) for draw in draws]) / n_episodes
    tail = 50.0 * (1.0 - CONFIDENCE)
    return np.asarray(np.percentile(weights @ values, [tail, 100.0 - tail], axis=0))


def _frame(n_panels: int, stacked: bool, width: float) -> tuple[Figure, list[Axes]]:
    rows, columns = (n_panels, 1) if stacked else (1, n_panels)
    size = max(5.0, width * columns), HEIGHT * rows + 0.8
    figure = Figure(figsize=size, layout="constrained")
    return figure, list(figure.subplots(rows, columns, squeeze=False).flat)


def _draw_groups(axes: Axes, groups: Groups) -> None:
    series = list(dict.fromkeys(name for group in groups.values() for name in group))
    plain = len(series) == 1
    width = 0.5 if plain else 0.8 / len(series)
    labels = []
    for tick, (label, group) in enumerate(groups.items()):
        shown = set()
        for name, values in group.items():
            offset = (series.index(name) - (len(series) - 1) / 2.0) * width
            colour = series.index(name)
            if plain and len(groups) < SIDE_BY_SIDE:
                colour = tick
            _box(axes, values, tick + offset, 0.86 * width, PALETTE[colour % len(PALETTE)])
            shown.add(len(values))
        labels.append(f"{label}\nn = {', '.join(map(str, sorted(shown)))}")
    axes.set_xticks(range(len(groups)), labels)
    axes.set_xlim(-0.6, len(groups) - 0.4)
    if not plain:
        for number, name in enumerate(series):
            axes.bar(0, 0, color=PALETTE[number % len(PALETTE)], edgecolor=INK, label=name)


def _box(axes: Axes, values: Sequence[float], x: float, width: float, colour: str) -> None:
    """Quartile box, median bar, whiskers within 1.5 IQR, outliers as circles."""
    if not len(values):
        axes.annotate("none", (x, 0.0), xytext=(0, 3), textcoords="offset points", ha="center",
                      fontsize=8, color=FAINT)  # fmt: skip
        return
    axes.boxplot(
        [list(values)],
        positions=[x],
        whis=1.5,
        widths=width,
        patch_artist=True,
        manage_ticks=False,
        boxprops={"edgecolor": INK, "linewidth": 0.9, "facecolor": colour},
        medianprops={"color": INK, "linewidth": 2.0, "solid_capstyle": "butt"},
        whiskerprops={"color": INK},
        capprops={"color": INK},
        flierprops={"marker": "o", "markersize": 4.0, "markeredgecolor": INK},
    )


def _draw_curve(axes: Axes, name: str, curve: Curve, colour: str) -> None:
    low, high = band(curve.y)
    axes.fill_between(curve.x, low, high, color=colour, alpha=0.25, linewidth=0.0)
    axes.plot(curve.x, curve.y.mean(axis=0), color=colour, linewidth=1.8, label=name)


def _finish(axes: Axes, title: str, axes_names: tuple[str, str]) -> None:
    axes.set_title(title, fontsize=10, loc="left")
    axes.set_xlabel(axes_names[0])
    axes.set_ylabel(axes_names[1])
    axes.set_ylim(bottom=0.0)
    axes.yaxis.set_major_locator(MaxNLocator(nbins=6))
    axes.yaxis.grid(visible=True, color="#dddddd", linewidth=0.7)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    axes.tick_params(axis="x", labelsize=8)


def _legend(figure: Figure, axes: Axes) -> None:
    """Above the panels, if there is more than one series."""
    handles, names = axes.get_legend_handles_labels()
    if names:
        figure.legend(
            handles, names, loc="outside upper center", ncols=len(names), frameon=False, fontsize=9
        )


def _caption(figure: Figure, caption: str) -> None:
    wrapped = textwrap.fill(caption, int(14 * figure.get_figwidth()), break_on_hyphens=False)
    figure.supxlabel(wrapped, fontsize=6.5, color=FAINT, family="monospace")
