"""Page of a figure: its size and text sizes, its panels, legend, note, caption and files."""

import json
import re
import textwrap
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import asdict, dataclass
from io import BytesIO
from itertools import chain
from pathlib import Path
from typing import Literal

from matplotlib import rc_context
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from baselines.evaluation.console import check_file
from baselines.evaluation.plot_style import FAINT, GRID
from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.atomic_write import write_atomically


@dataclass(frozen=True)
class PageStyle:
    """Size of a figure and scale of its elements."""

    width: float  # of the figure [inch]
    scale: float  # of letters, lines and panels, relative to the style `screen`

    @property
    def is_narrow(self) -> bool:
        """Whether wide elements are placed below each other, as in a column of a paper."""
        return self.width < 5.0

    def points(self, size: float) -> float:
        """Return the size of letters or lines on this page, given that of `screen` [pt]."""
        return self.scale * size


TITLE, LABEL, TICK, NOTE, LINE = 10.0, 9.0, 8.0, 7.5, 1.6
"""Sizes of text and width of a line in the style `screen` [pt]."""

LETTER = 0.0078  # approximate width of a letter per point of its size [inch]

PAGE_STYLES = {"screen": PageStyle(8.0, 1.0), "paper": PageStyle(3.35, 0.8)}
"""Page styles by name: as wide as a page of the docs, or as a column of a paper."""

_STYLE = ContextVar("page style", default=PAGE_STYLES["screen"])


@contextmanager
def page_style(name: str) -> Iterator[None]:
    """Draw all figures in this context in a page style."""
    before = _STYLE.set(PAGE_STYLES[name])
    try:
        yield
    finally:
        _STYLE.reset(before)


def style_in_use() -> PageStyle:
    """Return the page style in which figures are drawn."""
    return _STYLE.get()


@dataclass(frozen=True)
class Caption:
    """Caption of a figure, for the metadata of its file; the figure itself shows only the note."""

    text: str = ""  # what is shown, and how
    note: str = ""  # number of episodes that are shown
    command: str = ""  # the command line that draws the figure again
    code: tuple[str, ...] = ()  # hashes of the code that ran the episodes
    n: int = 0  # largest number of episodes of a mean or box; 0: not given

    def __str__(self) -> str:
        """Return the whole caption as text."""
        note = f"{self.note}." if self.note else ""
        code = f"Code {', '.join(self.code)}." if self.code else ""
        return " ".join(part for part in (self.text, note, code, self.command) if part)


DPI = 200
"""Resolution of figures [dots per inch]: captions are as wide as they were measured in it."""


class CaptionedFigure(Figure):
    """A figure with its caption."""

    caption = Caption()


HEIGHT, SINGLE_HEIGHT = 2.3, 3.0  # of a panel, and of a single one, in the style `screen` [inch]


def panel_grid(
    n_panels: int, least: float, height: float | None = None
) -> tuple[CaptionedFigure, list[Axes]]:
    """Return a figure and its panels, at least `least` wide [inch], in rows of similar length."""
    style = style_in_use()
    fitting = max(1, int(style.width / (style.scale * least)))
    rows = -(-n_panels // fitting)
    columns = -(-n_panels // rows)
    each = height or (SINGLE_HEIGHT if n_panels == 1 else HEIGHT)
    size = style.width, style.scale * (each * rows + 0.7)
    figure = CaptionedFigure(figsize=size, dpi=DPI, layout="constrained")
    axes = list(figure.subplots(rows, columns, squeeze=False).flat)
    for unused in axes[n_panels:]:
        unused.remove()
    return figure, axes[:n_panels]


def finish_panel(
    axes: Axes,
    title: str,
    axes_names: tuple[str, str],
    is_across: bool = False,
    margin: int = 0,
    lowest: float = 0.0,
) -> None:
    """Set labels, grid and ticks of a panel; its values (y, or x if `is_across`) start at zero
    unless the lowest is negative."""
    label_panel(axes, title, axes_names, margin)
    end = axes.dataLim.x1 if is_across else axes.dataLim.y1
    set_limits = axes.set_xlim if is_across else axes.set_ylim
    if lowest >= 0.0:
        set_limits(0.0, None if end > 0.0 else 1.0)
    axes.grid(visible=True, axis="x" if is_across else "y", color=GRID, linewidth=0.7)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)


def panel_width(axes: Axes) -> float:
    """Return the width of a panel with its labels [inch]."""
    grid = axes.get_gridspec()
    columns = grid.ncols if grid is not None else 1
    return float(style_in_use().width / columns)


def label_panel(axes: Axes, title: str, axes_names: tuple[str, str], margin: int = 0) -> None:
    """Set a panel's title, in several lines if it is long, and its axis labels (x, y).

    The title begins right of the names at the y axis, which are `margin` letters long.
    """
    style = style_in_use()
    room = 0.9 * panel_width(axes) - LETTER * style.points(TICK) * margin
    letters = max(1, int(room / (LETTER * style.points(TITLE))))
    lines = [
        wrapped_name(line, letters)
        for words in title.split("\n")
        for line in textwrap.wrap(words, letters, break_long_words=False, break_on_hyphens=False)
    ]
    axes.set_title("\n".join(lines), fontsize=style.points(TITLE), loc="left")
    axes.set_xlabel(axes_names[0], fontsize=style.points(LABEL))
    axes.set_ylabel(axes_names[1], fontsize=style.points(LABEL))
    axes.tick_params(labelsize=style.points(TICK))


def finish_figure(
    figure: CaptionedFigure, panels: Sequence[Axes], caption: Caption, order: Iterable[str] = ()
) -> Figure:
    """Draw the note and the legend, in this order of series; remove axis labels of inner panels."""
    _clear_inner_names(panels)
    _draw_legend(figure, panels, order)
    figure.caption = caption
    if caption.note:
        _draw_words(figure, caption.note, x=0.99, ha="right")
    return figure


def _clear_inner_names(panels: Sequence[Axes]) -> None:
    """Remove the label of an axis if the panel to the left, or below, has the same one."""
    columns = panels[0].get_gridspec().ncols  # type: ignore[union-attr]
    names = [(axes.get_xlabel(), axes.get_ylabel()) for axes in panels]
    for number, (x, y) in enumerate(names):
        if number + columns < len(names) and names[number + columns][0] == x:
            panels[number].set_xlabel("")
        if number % columns and names[number - 1][1] == y:
            panels[number].set_ylabel("")


def _draw_legend(figure: Figure, panels: Sequence[Axes], order: Iterable[str]) -> None:
    """Draw one legend above the panels, with every series once."""
    drawn = [zip(*axes.get_legend_handles_labels()[::-1], strict=True) for axes in panels]
    handles: dict[str, Artist] = dict(chain(*drawn))
    names = [name for name in order if name in handles]
    if not names:
        return
    style = style_in_use()
    letter, handle = LETTER * style.points(LABEL), 0.55 * style.scale
    labels = [wrapped_name(name, int((figure.get_figwidth() - handle) / letter)) for name in names]
    width = letter * max(len(line) for each in labels for line in each.split("\n")) + handle
    columns = max(1, min(len(names), int(figure.get_figwidth() / width)))
    rows = -(-len(names) // columns)
    columns = -(-len(names) // rows)
    lines = rows + sum(each.count("\n") for each in labels)
    figure.set_figheight(figure.get_figheight() + 0.2 * style.scale * lines)
    figure.legend(
        [handles[name] for name in names], labels, loc="outside upper center", ncols=columns,
        frameon=False, fontsize=style.points(LABEL), handlelength=2.6, columnspacing=1.4,
    )  # fmt: skip


def draw_caption(figure: Figure) -> None:
    """Draw the whole caption below the panels, instead of the note."""
    assert isinstance(figure, CaptionedFigure)
    _draw_words(figure, str(figure.caption), x=0.01, ha="left")


def _draw_words(figure: Figure, text: str, x: float, ha: Literal["left", "right"]) -> None:
    size, room, letters = style_in_use().points(NOTE), 0.97 * figure.bbox.width, len(text)
    drawn = figure.supxlabel(text, fontsize=size, color=FAINT, x=x, ha=ha)
    while (width := drawn.get_window_extent().width) > room and letters > 1:
        letters = min(letters - 1, int(letters * room / width) + 1)
        drawn.set_text(textwrap.fill(text, letters, break_on_hyphens=False))
    n_breaks = drawn.get_text().count("\n")
    figure.set_figheight(figure.get_figheight() + 1.25 * size / 72 * n_breaks)


def spans_decades(x: Float64[Array, " points"]) -> bool:
    """Return whether values are positive and span a ratio of at least 50: a logarithmic axis."""
    return bool(x.min() > 0.0 and x.max() / x.min() >= 50.0)


def wrapped_name(name: str, letters: int) -> str:
    """Break the name of a controller into lines of at most this length.

    It breaks after `:`, `,` and `+`; only a part that is longer also after `/`, or anywhere.

    >>> wrapped_name("dsgiff-frequent:beta=0.003,pause=4", 24)
    'dsgiff-frequent:\\nbeta=0.003,pause=4'
    """
    lines = [""]
    for part in re.split(r"(?<=[:,+])", name):
        for folder in re.split(r"(?<=/)", part) if len(part) > letters else [part]:
            for begin in range(0, len(folder), letters):
                piece = folder[begin : begin + letters]
                if lines[-1] and len(lines[-1]) + len(piece) > letters:
                    lines.append("")
                lines[-1] += piece
    return "\n".join(lines)


FORMATS = {  # by file ending: the metadata field of the caption, and the fields left out
    ".png": ("Description", ()),
    ".pdf": ("Subject", ("CreationDate",)),
    ".svg": ("Description", ("Date",)),
}


def check_plot(file: Path, option: str = "--plot") -> None:
    """Create the folder of a figure's file; ConfigError unless the file can be written."""
    check_file(option, file, FORMATS)


def save_figure(figure: Figure, file: Path, title: str = "Round trips") -> None:
    """Write a figure atomically, with its caption in its metadata and in `x.png.json`."""
    assert isinstance(figure, CaptionedFigure)
    ending, content = file.suffix.lower(), BytesIO()
    field, date = FORMATS[ending]
    metadata = {field: str(figure.caption), "Title": title} | dict.fromkeys(date)
    with rc_context({"svg.hashsalt": "swarm-forage", "svg.fonttype": "none", "pdf.fonttype": 42}):
        figure.savefig(content, format=ending[1:], dpi=DPI, metadata=metadata)
    write_atomically(file, content.getvalue())
    words = {"title": title, **asdict(figure.caption)}
    del words["n"]
    caption_file = file.with_name(f"{file.name}.json")
    write_atomically(caption_file, (json.dumps(words, indent=1) + "\n").encode())
