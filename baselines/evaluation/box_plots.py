"""Box plots in panels, as in the papers: quartile box, median bar, whiskers of 1.5 IQR."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import chain

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch

from baselines.evaluation.figure_page import (
    TICK,
    Caption,
    finish_figure,
    finish_panel,
    panel_grid,
    spans_decades,
    style_in_use,
    wrapped_name,
)
from baselines.evaluation.plot_style import FAINT, INK, SeriesStyle, is_dark, styles_of

Samples = Mapping[str, Mapping[str, Sequence[float]]]
"""Samples by tick of the axis and by series; the boxes of one tick are side by side."""

BOXES = (  # description of the boxes in a caption
    "Quartile boxes, median bars, whiskers within 1.5 times the interquartile range, outliers"
    " as circles."
)

BOX, ROW, MARGIN = 0.2, 0.3, 0.8
"""Minimum width of a vertical box and height of a horizontal one, with its gap; margin of a panel
[inch]."""

FLAT = 0.04  # share of the largest value; a dark box of at most this height has no white median bar

ON_DARK = "#AAAAAA"  # colour of a hatch on a dark fill

LETTERS, LINE_HEIGHT = 30, 0.135
"""Letters in a line of a label of a horizontal box, and height of the line [inch]."""

NAMED, SHORT = 2.2, 4.5
"""Minimum width of a panel of horizontal boxes with short labels, and with others [inch]."""


@dataclass(frozen=True)
class _Layout:
    """Layout of the boxes in all panels of a figure."""

    series: Sequence[str]
    styles: Mapping[str, SeriesStyle]  # by series, or by tick if there is only one series
    n: int  # usual size of a sample; boxes of other sizes are labelled
    is_horizontal: bool  # boxes are horizontal; ticks are names, at their left
    is_log: bool  # ticks are numbers that span decades

    @property
    def is_plain(self) -> bool:
        """Whether there is only one series."""
        return len(self.series) == 1

    def places(self, groups: Samples) -> list[float]:
        """Return the position of each tick on its axis."""
        return [math.log10(float(tick)) if self.is_log else at for at, tick in enumerate(groups)]


def box_panels(
    panels: Mapping[str, Samples],
    axes_names: tuple[str, str],
    caption: Caption,
    controllers: Mapping[str, str] | None = None,
) -> Figure:
    """Return a figure of box plots, a panel for each setup; `controllers` as in `styles_of`.

    A single series takes the style of each tick; its boxes are horizontal if ticks are names.
    """
    layout = _layout(panels, controllers or {}, caption.n)
    n_ticks, margin = max(map(len, panels.values())), 0
    if layout.is_horizontal:
        names = [wrapped_name(tick, LETTERS) for groups in panels.values() for tick in groups]
        row = max(ROW, LINE_HEIGHT * (1 + max(name.count("\n") for name in names)) + 0.06)
        least = NAMED if max(map(len, names)) < 8 else SHORT
        height = 0.5 + row * max(n_ticks, 3)
        margin = max(len(line) for name in names for line in name.split("\n"))
    else:
        least, height = MARGIN + BOX * n_ticks * len(layout.series), None
    figure, all_axes = panel_grid(len(panels), least, height)
    for axes, (title, groups) in zip(all_axes, panels.items(), strict=True):
        _draw_groups(axes, groups, layout)
        labels = axes_names[::-1] if layout.is_horizontal else axes_names
        lowest = min(chain(*chain(*(each.values() for each in groups.values()))), default=0.0)
        finish_panel(axes, title, labels, layout.is_horizontal, margin, lowest)
        axes.tick_params(axis="y" if layout.is_horizontal else "x", length=0.0)
    return finish_figure(figure, all_axes, caption, layout.series)


def _layout(panels: Mapping[str, Samples], controllers: Mapping[str, str], n: int) -> _Layout:
    every = [group for groups in panels.values() for group in groups.values()]
    ticks = list(dict.fromkeys(chain(*panels.values())))
    series = list(dict.fromkeys(chain(*every)))
    styles = styles_of(ticks if len(series) == 1 else series, controllers)
    n = n or max(len(values) for group in every for values in group.values())
    try:
        numbers = np.array(ticks, np.float64)
    except ValueError:  # ticks are names
        return _Layout(series, styles, n, is_horizontal=len(series) == 1, is_log=False)
    return _Layout(series, styles, n, is_horizontal=False, is_log=spans_decades(numbers))


def _draw_groups(axes: Axes, groups: Samples, layout: _Layout) -> None:
    places = layout.places(groups)
    step = min([*np.diff(sorted(places)), 1.0])
    width = (0.6 if layout.is_plain else 0.84 / len(layout.series)) * step
    boxes = [
        (values, place + (layout.series.index(name) - (len(layout.series) - 1) / 2.0) * width,
         layout.styles[tick if layout.is_plain else name])
        for place, (tick, group) in zip(places, groups.items(), strict=True)
        for name, values in group.items()
    ]  # fmt: skip
    _draw_boxes(axes, boxes, 0.86 * width, layout)
    _set_ticks(axes, groups, layout, (min(places) - 0.6 * step, max(places) + 0.6 * step))
    for name in () if layout.is_plain else layout.series:
        colour, hatch = layout.styles[name].colour, layout.styles[name].hatch
        axes.bar(places[0], 0, color=colour, hatch=hatch, edgecolor=_hatch_on(colour), label=name)


def _set_ticks(axes: Axes, groups: Samples, layout: _Layout, limits: tuple[float, float]) -> None:
    if layout.is_horizontal:
        axes.set_yticks(range(len(groups)), [wrapped_name(tick, LETTERS) for tick in groups])
        axes.set_ylim(*limits[::-1])  # the first on top
    elif layout.is_log:
        places = layout.places(groups)
        decades = range(round(min(places)), round(max(places)) + 1)
        axes.set_xticks(decades, [f"$10^{{{decade}}}$" for decade in decades])
        axes.set_xlim(*limits)
    else:
        axes.set_xticks(range(len(groups)), list(groups))
        axes.set_xlim(*limits)


def _hatch_on(colour: str) -> str:
    """Return the hatch colour for a fill of this colour: visible, also in a flat box."""
    return ON_DARK if is_dark(colour) else INK


Box = tuple[Sequence[float], float, SeriesStyle]  # values, place on the axis, and style


def _draw_boxes(axes: Axes, boxes: Sequence[Box], width: float, layout: _Layout) -> None:
    scale = style_in_use().scale
    highest = max(max(values, default=0.0) for values, _, _ in boxes)
    drawn = axes.boxplot(
        [list(values) for values, _, _ in boxes],
        positions=[at for _, at, _ in boxes],
        orientation="horizontal" if layout.is_horizontal else "vertical",
        whis=1.5,
        widths=width,
        patch_artist=True,
        manage_ticks=False,
        boxprops={"edgecolor": INK, "linewidth": 0.9 * scale},
        medianprops={"color": INK, "linewidth": 1.6 * scale, "solid_capstyle": "butt"},
        whiskerprops={"color": INK, "linewidth": scale},
        capprops={"color": INK, "linewidth": scale},
        flierprops={"marker": "o", "markersize": 3.5 * scale, "markeredgecolor": INK},
    )
    parts = zip(boxes, drawn["boxes"], drawn["medians"], strict=True)
    for (values, at, style), box, median in parts:
        box.set_facecolor(style.colour)
        if len(values) != layout.n or not len(values):
            _annotate_sample_size(axes, values, at, layout)
        if not len(values):
            continue
        low, high = np.percentile(values, [25.0, 75.0])
        if is_dark(style.colour) and high - low > FLAT * highest:
            median.set(color="white", linewidth=0.8 * scale)
        if style.hatch and not layout.is_plain:
            hatch = PathPatch(box.get_path(), facecolor="none", linewidth=0.0, zorder=2.5)
            hatch.set(edgecolor=_hatch_on(style.colour), hatch=style.hatch)
            axes.add_patch(hatch)


def _annotate_sample_size(axes: Axes, values: Sequence[float], at: float, layout: _Layout) -> None:
    """Write n, or "none", at the end of a box whose sample size differs from the usual one."""
    text = f"n = {len(values)}" if len(values) else "none"
    end = max(values, default=0.0)
    place, offset = ((end, at), (4, 0)) if layout.is_horizontal else ((at, end), (0, 4))
    axes.annotate(
        text, place, xytext=offset, textcoords="offset points", color=FAINT,
        ha="left" if layout.is_horizontal else "center",
        va="center" if layout.is_horizontal else "bottom",
        fontsize=style_in_use().points(TICK - 1.0), annotation_clip=False,
    )  # fmt: skip
