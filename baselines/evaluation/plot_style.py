"""The style of every figure: colours, lines, panels, legend and caption; and saving it."""

import textwrap
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from io import BytesIO
from itertools import cycle, islice
from pathlib import Path
from typing import Any

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from baselines.evaluation.output_files import check_file
from swarm_forage_env.atomic_write import write_atomically

FORMATS = {".png": "Description", ".pdf": "Subject", ".svg": "Description"}
"""Endings of a figure's file, and the field of its metadata that holds the command."""

PALETTE = ("#56B4E9", "#D55E00", "#009E73", "#F0E442", "#CC79A7", "#0072B2", "#E69F00")
"""Fills that colour-blind readers tell apart; neighbours differ in lightness too.

Source: Okabe and Ito 2008.
"""

HATCHES = ("", "///", "...", "xxx", "\\\\\\", "+++", "ooo")
"""Of fills that only a legend names: in print without colour they still differ."""

INK, FAINT, GRID = "#222222", "#666666", "#dddddd"

LETTER_WIDTH = 0.105
"""Of a label of full size [inch]."""

TITLE_LETTERS = 46
"""Of a line of a panel's title."""

CAPTION_SIZE, CAPTION_LETTERS = 7.0, 15
"""Size of a caption, and letters in an inch of its lines."""


@dataclass(frozen=True)
class LineStyle:
    """The style of one curve: colour, and for print dashes and marker."""

    colour: str
    dashes: str
    marker: str


def _line_styles() -> tuple[LineStyle, ...]:
    """Twelve distinct line styles, without yellow, which is lost on white."""
    colours = [colour for colour in PALETTE if colour != "#F0E442"]
    kinds = zip(cycle(colours), cycle(("-", "--", "-.", ":")), cycle("os^Dv"), strict=False)
    return tuple(LineStyle(*each) for each in islice(kinds, 12))


LINES = _line_styles()
"""Styles of curves, all different."""


def check_plot(file: Path, option: str = "--plot") -> None:
    """Raise ConfigError unless a figure can be written to this file; its folder is made."""
    check_file(option, file, FORMATS)


def save_figure(figure: Figure, file: Path, command: str, title: str = "Round trips") -> None:
    """Write a figure to a file, whole or not at all; its metadata name the command and no date."""
    ending, content = file.suffix.lower(), BytesIO()
    metadata: dict[str, str | None] = {FORMATS[ending]: command, "Title": title}
    if ending == ".pdf":
        metadata["CreationDate"] = None
    if ending == ".svg":
        metadata["Date"] = None
    with rc_context({"svg.hashsalt": "swarm-forage", "svg.fonttype": "none"}):
        figure.savefig(content, format=ending[1:], dpi=200, metadata=metadata)
    write_atomically(file, content.getvalue())


HEIGHT = 3.3
"""Of a panel [inch]."""

BROADEST = 13.0
"""A row of panels, at most [inch]."""


def panel_grid(n_panels: int, width: float, stacked: bool = False) -> tuple[Figure, list[Axes]]:
    """A figure of panels of this width [inch]: as many in a row as fit, or stacked."""
    fitting = 1 if stacked else max(1, int(BROADEST / width))
    rows = -(-n_panels // fitting)
    columns = -(-n_panels // rows)
    size = max(5.0, width * columns), HEIGHT * rows + 0.8
    figure = Figure(figsize=size, layout="constrained")
    axes = list(figure.subplots(rows, columns, squeeze=False).flat)
    for unused in axes[n_panels:]:
        unused.remove()
    return figure, axes[:n_panels]


def finish_panel(axes: Axes, title: str, axes_names: tuple[str, str]) -> None:
    """Set labels, grid and ticks of a panel whose y axis starts at zero."""
    label_panel(axes, title, axes_names)
    axes.set_ylim(0.0, None if axes.dataLim.y1 > 0.0 else 1.0)
    axes.yaxis.set_major_locator(MaxNLocator(nbins=6))
    axes.yaxis.grid(visible=True, color=GRID, linewidth=0.7)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)


def label_panel(axes: Axes, title: str, axes_names: tuple[str, str]) -> None:
    """Set a panel's title and axis labels x, y; a long title is broken."""
    lines = [textwrap.fill(line, TITLE_LETTERS) for line in title.split("\n")]
    axes.set_title("\n".join(lines), fontsize=10, loc="left")
    axes.set_xlabel(axes_names[0])
    axes.set_ylabel(axes_names[1])
    axes.tick_params(labelsize=8.5)


def draw_legend(figure: Figure, panels: Sequence[Axes], order: Iterable[str]) -> None:
    """Draw one legend above the panels, with every series once."""
    handles: dict[str, Any] = {}
    for axes in panels:
        found, names = axes.get_legend_handles_labels()
        handles |= dict(zip(names, found, strict=True))
    shown = [name for name in order if name in handles]
    if shown:
        width = 0.6 + 0.085 * max(map(len, shown))
        columns = max(1, min(len(shown), int(figure.get_figwidth() / width)))
        rows = -(-len(shown) // columns)
        figure.set_figheight(figure.get_figheight() + 0.2 * (rows - 1))
        figure.legend(
            [handles[name] for name in shown], shown, loc="outside upper center",
            ncols=columns, frameon=False, fontsize=9, handlelength=3.0,
        )  # fmt: skip


def draw_caption(figure: Figure, text: str) -> None:
    """Draw the caption below the panels."""
    letters = int(CAPTION_LETTERS * figure.get_figwidth())
    wrapped = textwrap.fill(text, letters, break_on_hyphens=False)
    figure.set_figheight(figure.get_figheight() + 0.12 * wrapped.count("\n"))
    figure.supxlabel(wrapped, fontsize=CAPTION_SIZE, color=FAINT, family="monospace")
