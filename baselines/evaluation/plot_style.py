"""The style of every figure: colours, lines, panels, legend and caption; and saving it."""

import textwrap
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from io import BytesIO
from itertools import count
from pathlib import Path
from typing import Any
from zlib import crc32

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from baselines.evaluation.output_files import check_file
from swarm_forage_env.atomic_write import write_atomically

FORMATS = {".png": "Description", ".pdf": "Subject", ".svg": "Description"}
"""Endings of a figure's file, and the field of its metadata that holds the command."""

PALETTE = {
    "silver": "#BBBBBB",
    "vermilion": "#D55E00",
    "orange": "#E69F00",
    "blue": "#0072B2",
    "sky": "#56B4E9",
    "green": "#009E73",
    "pink": "#CC79A7",
    "wine": "#882255",
    "indigo": "#332288",
    "black": "#222222",
}
"""Ten colours that colour-blind readers tell apart; all are seen on white, in lines as in fills.

Source: Okabe and Ito 2008 without its yellow; wine and indigo from P. Tol 2021, "muted".
"""

MARKERS, DASHES = "os^DvPXd<>p*", ("-", "--", "-.", ":")

HATCHES = (
    "", "///", "...", "xxx", "\\\\\\", "+++", "ooo", "---", "|||", "OO", "**", "//..",
)  # fmt: skip

CONTROLLERS = {
    "nc": ("silver", 0),
    "ssgikf": ("vermilion", 1),
    "dsgikf": ("orange", 2),
    "ssgiff": ("blue", 3),
    "dsgiff": ("sky", 4),
    "dsgiff-penalised": ("indigo", 5),
    "dsgiff-frequent": ("indigo", 6),
    "ssgikf-sceptical": ("vermilion", 10),
    "sikf": ("green", 8),
    "covariance": ("indigo", 5),
    "subsumption": ("green", 8),
    "boids-goal": ("sky", 6),
    "boids-static": ("vermilion", 2),
    "boids-adaptive": ("indigo", 5),
    "learned-weighting": ("pink", 7),
    "learned-motion": ("green", 8),
    "learned-both": ("wine", 9),
    "no-error": ("black", 6),
    "global": ("black", 5),
    "oracle-weighting": ("black", 11),
    "oracle-weighting-frequent": ("black", 4),
    "random": ("silver", 0),
    "weighting": ("pink", 7),
    "motion": ("green", 8),
    "weighting-both": ("wine", 9),
    "motion-both": ("wine", 9),
}
"""Colour and mark of the named controllers, and of bundled policies, as the learned ones."""

INK, FAINT, GRID = "#222222", "#666666", "#dddddd"

LETTER_WIDTH = 0.105
"""Of a label of full size [inch]."""

TITLE_LETTERS = 46
"""Of a line of a panel's title."""

CAPTION_SIZE, CAPTION_LETTERS = 7.0, 15
"""Size of a caption, and letters in an inch of its lines."""


@dataclass(frozen=True)
class SeriesStyle:
    """The style of one series: its colour, and what tells it apart without colour."""

    colour: str
    dashes: str
    """Of a line."""
    marker: str
    """On a line."""
    hatch: str
    """Of a fill."""


def styles_of(
    names: Iterable[str], controllers: Mapping[str, str] | None = None
) -> dict[str, SeriesStyle]:
    """A style for each series of a figure, by the controller of that name.

    The colour is that of the controller, whatever its parameters, in every figure. So are marker,
    dashes and hatch, as long as no two series of the figure would have the same ones; then the
    later one, or the one with parameters, takes the next. A series that is called otherwise than
    its controller stands in `controllers`.
    """
    found: dict[str, SeriesStyle] = {}
    taken: set[int] = set()
    known = controllers or {}
    asked = {name: known.get(name, name) for name in names}
    for name in sorted(asked, key=lambda each: ":" in asked[each]):
        colour, mark = _colour_and_mark(asked[name])
        if len(taken) < len(MARKERS):
            mark = next(
                each % len(MARKERS) for each in count(mark) if each % len(MARKERS) not in taken
            )
        taken.add(mark)
        found[name] = _style(colour, mark)
    return {name: found[name] for name in asked}


def style_of(name: str) -> SeriesStyle:
    """The style of a controller, with its parameters or without, where it stands alone."""
    return styles_of([name])[name]


def nth_style(number: int) -> SeriesStyle:
    """The style of what is no controller, by its number: 0 to 9 differ in colour."""
    colours = list(PALETTE)
    return _style(colours[(number + 1) % len(colours)], number % len(MARKERS))


def is_dark(colour: str) -> bool:
    """Whether lines on a fill of this colour must be white to be seen."""
    return sum(share * part for share, part in zip(LUMA, to_rgb(colour), strict=True)) < 0.3


LUMA = (0.299, 0.587, 0.114)
"""Shares of red, green and blue in the lightness of a colour (ITU-R BT.601)."""


def _colour_and_mark(name: str) -> tuple[str, int]:
    """Colour and mark of a controller; those of an unknown one follow from its letters."""
    base = name.partition(":")[0]
    number = crc32(base.encode())
    colour, mark = CONTROLLERS.get(base, (list(PALETTE)[number % len(PALETTE)], number // 16))
    return colour, (mark if base == name else crc32(name.encode())) % len(MARKERS)


def _style(colour: str, mark: int) -> SeriesStyle:
    return SeriesStyle(PALETTE[colour], DASHES[mark % len(DASHES)], MARKERS[mark], HATCHES[mark])


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


def draw_frame(axes: Axes, controller: str) -> None:
    """Draw the frame of a heat map in the colour of its controller."""
    axes.spines[:].set(color=style_of(controller).colour, linewidth=2.5)


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
