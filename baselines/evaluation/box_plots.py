"""Box plots in panels, as in the papers: quartile box, median bar, whiskers of 1.5 IQR."""

from collections.abc import Mapping, Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch

from baselines.evaluation.plot_style import (
    BROADEST,
    FAINT,
    INK,
    LETTER_WIDTH,
    SeriesStyle,
    draw_caption,
    draw_legend,
    finish_panel,
    is_dark,
    panel_grid,
    styles_of,
)

Samples = Mapping[str, Mapping[str, Sequence[float]]]
"""Samples by tick of the axis and by series; ticks stand apart, the series of a tick together."""

BOXES = (
    "Quartile boxes, median bars, whiskers within 1.5 times the interquartile range, outliers"
    " as circles."
)
"""What a caption says of them."""

SIDE_BY_SIDE = 8
"""Most boxes in a panel that still has others beside it; larger panels stand below each other."""

UPRIGHT = 0.09
"""Room for each letter of labels that stand upright, as too many boxes make them [inch]."""

BOX, MARGIN = 0.62, 1.1
"""Width of a box with its distance, and of the margin of a panel [inch]."""


def box_panels(
    panels: Mapping[str, Samples],
    axes_names: tuple[str, str],
    text: str,
    controllers: Mapping[str, str] | None = None,
) -> Figure:
    """A figure of box plots, a panel for each setup; the text is the caption.

    Series, or ticks where there is but one series, that are called otherwise than their controllers
    stand in `controllers`.
    """
    series = list(dict.fromkeys(
        name for groups in panels.values() for group in groups.values() for name in group
    ))  # fmt: skip
    ticks = max(map(len, panels.values()))
    letters = max(len(line) for groups in panels.values() for line in _lines(groups))
    tick = max(BOX * len(series), LETTER_WIDTH * letters)
    upright = ticks * tick > BROADEST
    if upright:
        tick = BOX * len(series)
    plain = len(series) == 1
    names = [tick for groups in panels.values() for tick in groups] if plain else series
    styles = styles_of(names, controllers)
    stacked = ticks * len(series) > SIDE_BY_SIDE
    figure, all_axes = panel_grid(len(panels), MARGIN + tick * max(ticks, 4 / len(series)), stacked)
    for axes, (title, groups) in zip(all_axes, panels.items(), strict=True):
        _draw_groups(axes, groups, series, styles)
        finish_panel(axes, title, axes_names)
        axes.tick_params(axis="x", length=0.0)
        if upright:
            figure.set_figheight(figure.get_figheight() + UPRIGHT * letters)
            names = [label.get_text().replace("\n", " ") for label in axes.get_xticklabels()]
            axes.set_xticks(axes.get_xticks(), names, rotation=90)
    draw_legend(figure, all_axes, series)
    draw_caption(figure, text)
    return figure


def _lines(groups: Samples) -> list[str]:
    return [line for tick in groups for line in tick.split("\n")]


def _draw_groups(
    axes: Axes, groups: Samples, series: Sequence[str], styles: Mapping[str, SeriesStyle]
) -> None:
    plain = len(series) == 1
    width = 0.5 if plain else 0.8 / len(series)
    labels = []
    for tick, (label, group) in enumerate(groups.items()):
        shown = set()
        for name, values in group.items():
            place = series.index(name)
            x = tick + (place - (len(series) - 1) / 2.0) * width
            style = styles[label if plain else name]
            _box(axes, values, x, 0.86 * width, style.colour, "" if plain else style.hatch)
            shown.add(len(values))
        labels.append(f"{label}\nn = {', '.join(map(str, sorted(shown)))}")
    axes.set_xticks(range(len(groups)), labels)
    axes.set_xlim(-0.6, len(groups) - 0.4)
    if not plain:
        for name in series:
            colour, hatch = styles[name].colour, styles[name].hatch
            axes.bar(0, 0, color=colour, hatch=hatch, edgecolor=_line_on(colour), label=name)


def _line_on(colour: str) -> str:
    """The colour of lines and hatches on a fill of this colour."""
    return "white" if is_dark(colour) else INK


def _box(
    axes: Axes, values: Sequence[float], x: float, width: float, colour: str, hatch: str
) -> None:
    """Draw one box: quartiles, median bar, whiskers within 1.5 IQR, outliers as circles."""
    if not len(values):
        axes.annotate("none", (x, 0.0), xytext=(0, 3), textcoords="offset points", ha="center",
                      fontsize=8, color=FAINT)  # fmt: skip
        return
    drawn = axes.boxplot(
        [list(values)],
        positions=[x],
        whis=1.5,
        widths=width,
        patch_artist=True,
        manage_ticks=False,
        boxprops={"edgecolor": INK, "linewidth": 0.9, "facecolor": colour},
        medianprops={
            "color": _line_on(colour),
            "linewidth": 0.8 if is_dark(colour) else 1.6,  # a flat box is not to vanish under it
            "solid_capstyle": "butt",
        },
        whiskerprops={"color": INK},
        capprops={"color": INK},
        flierprops={"marker": "o", "markersize": 4.0, "markeredgecolor": INK},
    )
    if hatch:
        outline, line = drawn["boxes"][0].get_path(), _line_on(colour)
        axes.add_patch(
            PathPatch(outline, facecolor="none", edgecolor=line, linewidth=0.0, hatch=hatch)
        )
