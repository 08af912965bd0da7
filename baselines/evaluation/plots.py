"""The boxplot of the papers: quartile box, median bar, whiskers of 1.5 IQR, outliers as circles."""

import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from baselines.evaluation.files import check_file

FORMATS = {".png": "Description", ".pdf": "Subject", ".svg": "Description"}
"""Endings of a figure's file, and the field of its metadata that holds the command."""

PALETTE = ("#56B4E9", "#D55E00", "#009E73", "#F0E442", "#CC79A7", "#0072B2", "#E69F00")
"""Fills that colour-blind readers tell apart; neighbours differ in lightness too.

Source: Okabe and Ito 2008.
"""

INK, FAINT = "#222222", "#666666"

BOX_WIDTH, LETTER_WIDTH = 0.85, 0.105
"""Least width of a box with its margin, and width of a letter of its label [inch]."""


def check_plot(file: Path) -> None:
    """ConfigError unless a figure can be written to this file; its folder is made."""
    check_file("--plot", file, FORMATS)


def boxplot(samples: Mapping[str, Sequence[float]], axis: str, caption: str) -> Figure:
    """One box for each sample; the caption, which names the command, stands below."""
    labels = [_label(name, sample) for name, sample in samples.items()]
    longest = max(len(line) for label in labels for line in label.splitlines())
    width = 1.2 + len(samples) * max(BOX_WIDTH, LETTER_WIDTH * longest)
    figure = Figure(figsize=(max(4.8, width), 4.2), layout="constrained")
    axes = figure.subplots()
    _draw(axes, samples)
    axes.set_ylabel(axis)
    axes.set_xticks(range(1, len(samples) + 1), labels)
    wrapped = textwrap.fill(caption, int(16 * figure.get_figwidth()), break_on_hyphens=False)
    figure.supxlabel(wrapped, fontsize=6.5, color=FAINT, family="monospace")
    return figure


def save(figure: Figure, file: Path, command: str, title: str = "Round trips") -> None:
    """Write the figure; its metadata name the command and hold no date."""
    ending = file.suffix.lower()
    metadata: dict[str, str | None] = {FORMATS[ending]: command, "Title": title}
    if ending == ".pdf":
        metadata["CreationDate"] = None
    if ending == ".svg":
        metadata["Date"] = None
    with rc_context({"svg.hashsalt": "swarm-forage", "svg.fonttype": "none"}):
        figure.savefig(file, dpi=200, metadata=metadata)


def _draw(axes: Axes, samples: Mapping[str, Sequence[float]]) -> None:
    boxes = axes.boxplot(
        [list(sample) for sample in samples.values()],
        whis=1.5,
        widths=0.5,
        patch_artist=True,
        boxprops={"edgecolor": INK, "linewidth": 1.0},
        medianprops={"color": INK, "linewidth": 2.0, "solid_capstyle": "butt"},
        whiskerprops={"color": INK},
        capprops={"color": INK},
        flierprops={"marker": "o", "markersize": 4.5, "markeredgecolor": INK},
    )
    for number, box in enumerate(boxes["boxes"]):
        box.set_facecolor(PALETTE[number % len(PALETTE)])
    axes.set_ylim(bottom=0.0)
    axes.yaxis.set_major_locator(MaxNLocator(integer=True))
    axes.yaxis.grid(visible=True, color="#dddddd", linewidth=0.7)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    axes.tick_params(axis="x", length=0.0)


def _label(name: str, sample: Sequence[float]) -> str:
    """A controller's name and parameters in lines, and the number of its episodes."""
    lines = name.replace(":", ":\n").replace(",", ",\n")
    return f"{lines}\nn = {len(sample)}"
