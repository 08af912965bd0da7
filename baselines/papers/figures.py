"""Figures of the papers: box plots and curves, each from its experiments."""

import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import ClassVar

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from baselines.evaluation.box_plots import BOXES, box_panels
from baselines.evaluation.figure_page import (
    TICK,
    Caption,
    finish_figure,
    label_panel,
    page_style,
    panel_grid,
    save_figure,
    style_in_use,
)
from baselines.evaluation.line_plots import BANDS, Means, curve_panels, mean_curve
from baselines.evaluation.plot_style import INK
from baselines.papers.experiments import Metric, Results, Source, UsesFields, present, round_trips
from swarm_forage_env.foraging.episode import ForagingEpisode

ENDINGS = {"screen": (".png", ".svg"), "paper": (".png", ".pdf")}
"""Files of each figure, by page style."""

WIDEST = 1.5  # |log2 ratio| at which the colours of a heat map end
DARK = 0.9  # |log2 ratio| from which the colours of a heat map are dark
Against = tuple[Source, Source]  # a source, and the base that it is compared with


@dataclass(frozen=True)
class PaperFigure(UsesFields):
    """Base of the figures of a paper."""

    name: str  # name of the file without ending: `tr14`
    caption: str  # without the command
    reading: ClassVar[str] = ""  # meaning of boxes, bands or bars
    counted: ClassVar[str] = "episodes"

    def draw(self, results: Results, command: str) -> Figure:
        """Draw the figure, with the command that made it in the caption.

        All experiments must have the same number of episodes.
        """
        n = len(next(iter(results.values())))
        text = f"{self.caption} {self.reading}".rstrip()
        return self._draw(results, Caption(text, f"n = {n} {self.counted} each", command, n=n))

    def _draw(self, results: Results, caption: Caption) -> Figure:
        raise NotImplementedError


@dataclass(frozen=True)
class Boxes(PaperFigure):
    """Box plots of a metric, with a panel for each setup."""

    axes: tuple[str, str]  # names of x and y
    panels: Mapping[str, Mapping[str, Mapping[str, Source]]]  # by panel, tick of x and series
    metric: Metric = round_trips  # episodes with NaN are left out
    reading: ClassVar[str] = BOXES

    def _draw(self, results: Results, caption: Caption) -> Figure:
        panels = {
            title: {
                tick: {name: present(results, each, self.metric) for name, each in series.items()}
                for tick, series in panel.items()
            }
            for title, panel in self.panels.items()
        }
        controllers = controllers_of(
            (name or tick, source)
            for panel in self.panels.values()
            for tick, series in panel.items()
            for name, source in series.items()
        )
        return box_panels(panels, self.axes, caption, controllers)


@dataclass(frozen=True)
class Curves(PaperFigure):
    """Mean curves over time or number of robots, with a panel for each setup."""

    axes: tuple[str, str]  # names of x and y
    panels: Mapping[str, Mapping[str, Source]]  # sources by panel and series
    curve: Callable[[Sequence[ForagingEpisode]], Means]
    reading: ClassVar[str] = BANDS

    def _draw(self, results: Results, caption: Caption) -> Figure:
        panels = {
            title: {name: self.curve(source.draw(results)) for name, source in panel.items()}
            for title, panel in self.panels.items()
        }
        controllers = controllers_of(chain(*(panel.items() for panel in self.panels.values())))
        return curve_panels(panels, self.axes, caption, controllers)


@dataclass(frozen=True)
class RatioMaps(PaperFigure):
    """Heat maps of round trips as a multiple of those of a base, with a panel for each setup."""

    panels: Mapping[str, Mapping[str, Mapping[str, Against]]]
    """Source and base by panel, row and column; a base against itself shows its round trips."""
    reading: ClassVar[str] = "White: as many; blue: more; red: fewer."

    def _draw(self, results: Results, caption: Caption) -> Figure:
        n_rows = max(map(len, self.panels.values()))
        figure, panels = panel_grid(len(self.panels), 3.6, max(2.0, 0.25 * n_rows))
        for axes, (title, rows) in zip(panels, self.panels.items(), strict=True):
            columns = list(next(iter(rows.values())))
            _draw_ratios(axes, results, [list(row.values()) for row in rows.values()])
            axes.set_xticks(range(len(columns)), columns)
            axes.set_yticks(range(len(rows)), [shortened(row) for row in rows])
            label_panel(axes, title, ("", ""))
        return finish_figure(figure, panels, caption)


def _draw_ratios(axes: Axes, results: Results, rows: Sequence[Sequence[Against]]) -> None:
    ratios = np.array([[ratio_of_trips(results, *each) for each in row] for row in rows])
    shades = np.log2(np.maximum(ratios, 0.5**WIDEST))  # also of a ratio of zero
    axes.imshow(shades, cmap="RdBu", vmin=-WIDEST, vmax=WIDEST, aspect="auto")
    for (row, column), ratio in np.ndenumerate(ratios):
        source, base = rows[row][column]
        text = f"{mean_trips(results, base):.0f}" if source == base else f"{ratio:.2f}"
        is_dark = not ratio or abs(math.log2(ratio)) > DARK
        axes.text(
            column, row, text, ha="center", va="center", fontsize=style_in_use().points(TICK),
            color="white" if is_dark else INK,
        )  # fmt: skip


def shortened(name: str) -> str:
    """Return the name of a controller, of which a file is told by its folder and first name.

    >>> shortened("network:runs/seed-3/best.safetensors,chance=true")
    'seed-3/best,chance=true'
    """
    return re.sub(r"^.*?([^/:]*/[^/,]*)\.\w+(?=,|$)", r"\1", name)


def mean_trips(results: Results, source: Source) -> float:
    """Return the mean round trips of a source."""
    return float(np.mean(present(results, source, round_trips)))


def ratio_of_trips(results: Results, source: Source, base: Source) -> float:
    """Return the ratio of the mean round trips of a source to a base; NaN for a base of zero."""
    trips = mean_trips(results, base)
    return mean_trips(results, source) / trips if trips else math.nan


def controllers_of(named: Iterable[tuple[str, Source]]) -> dict[str, str]:
    """Return the controller of each series, without parameters if its sources differ in them."""
    controllers: dict[str, set[str]] = {}
    for name, source in named:
        controllers.setdefault(name, set()).update(each.controller for each in source.experiments)
    return {
        name: min(each) if len(each) == 1 else min(each).partition(":")[0]
        for name, each in controllers.items()
    }


def time_of_each_robot(episodes: Sequence[ForagingEpisode]) -> Means:
    """Return the time until k robots had visited both areas [s], at most the duration."""
    n_robots = episodes[0].n_robots
    times = np.full((len(episodes), n_robots), episodes[0].duration_s)
    for row, episode in zip(times, episodes, strict=True):
        row[: len(episode.recruited_at_s)] = episode.recruited_at_s
    return mean_curve(np.arange(1.0, n_robots + 1.0), times)


def recruitment_time_if_finished(episode: ForagingEpisode) -> float:
    """Metric: time until all robots had visited both areas [s]; else NaN."""
    time = episode.recruitment_time_s
    return math.nan if time is None else time


def write_figures(
    figures: Sequence[PaperFigure],
    results: Results,
    folder: Path,
    command: str,
    style: str = "screen",
) -> None:
    """Write every figure to a folder in a page style, in each format of the style."""
    folder.mkdir(parents=True, exist_ok=True)
    for paper_figure in figures:
        with page_style(style):
            figure = paper_figure.draw(results, command)
            for ending in ENDINGS[style]:
                save_figure(figure, folder / f"{paper_figure.name}{ending}", paper_figure.caption)
