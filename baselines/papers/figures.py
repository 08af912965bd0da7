"""Figures of the papers: box plots and curves, each from its experiments."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Protocol

import numpy as np
from matplotlib.figure import Figure

from baselines.evaluation.box_plots import BOXES, box_panels
from baselines.evaluation.figure_files import save_figure
from baselines.evaluation.figure_page import Caption, page_style
from baselines.evaluation.line_plots import BANDS, Curve, curve_panels
from baselines.papers.experiments import Experiment, Metric, Results, Source, round_trips
from swarm_forage_env.foraging.episode import ForagingEpisode

ENDINGS = {"screen": (".png", ".svg"), "paper": (".png", ".pdf")}
"""Files of each figure, by page style."""


class PaperFigure(Protocol):
    """Protocol of a figure of a paper."""

    @property
    def name(self) -> str:
        """Name of the file, without ending: `tr14`."""
        ...

    @property
    def caption(self) -> str:
        """The caption, without the command."""
        ...

    @property
    def reading(self) -> str:
        """How boxes, bands or bars are to be read; empty where the caption says it."""
        ...

    @property
    def experiments(self) -> tuple[Experiment, ...]:
        """The experiments whose episodes are used."""
        ...

    def draw(self, results: Results, command: str) -> Figure:
        """Draw the figure, with the command that made it in the caption."""
        ...


@dataclass(frozen=True)
class Boxes:
    """Box plots of a metric, a panel for each setup."""

    name: str
    caption: str
    axes: tuple[str, str]
    """Names of x and y."""
    panels: Mapping[str, Mapping[str, Mapping[str, Source]]]
    """Sources by panel, tick of x and series."""
    metric: Metric = round_trips
    """NaN leaves an episode out."""
    reading: ClassVar[str] = BOXES

    @property
    def experiments(self) -> tuple[Experiment, ...]:
        """The experiments whose episodes are used."""
        ticks = [tick for panel in self.panels.values() for tick in panel.values()]
        return tuple(
            experiment
            for tick in ticks
            for source in tick.values()
            for experiment in source.experiments
        )

    def draw(self, results: Results, command: str) -> Figure:
        """Draw the figure, with the command that made it in the caption."""

        def values(source: Source) -> list[float]:
            found = [self.metric(episode) for episode in source.draw(results)]
            return [value for value in found if not math.isnan(value)]

        panels = {
            title: {
                tick: {name: values(source) for name, source in series.items()}
                for tick, series in panel.items()
            }
            for title, panel in self.panels.items()
        }
        caption = caption_of(self, results, command)
        return box_panels(panels, self.axes, caption, self._controllers())

    def _controllers(self) -> dict[str, str]:
        """The controller of each series, or of each tick where the series has no name."""
        sources: dict[str, list[Source]] = {}
        for panel in self.panels.values():
            for tick, series in panel.items():
                for name, source in series.items():
                    sources.setdefault(name or tick, []).append(source)
        return {name: controller_of(each) for name, each in sources.items()}


@dataclass(frozen=True)
class Curves:
    """Mean curves over time or number of robots, a panel for each setup."""

    name: str
    caption: str
    axes: tuple[str, str]
    """Names of x and y."""
    panels: Mapping[str, Mapping[str, Source]]
    """Sources by panel and series."""
    curve: Callable[[Sequence[ForagingEpisode]], Curve]
    reading: ClassVar[str] = BANDS

    @property
    def experiments(self) -> tuple[Experiment, ...]:
        """The experiments whose episodes are used."""
        sources = [source for panel in self.panels.values() for source in panel.values()]
        return tuple(experiment for source in sources for experiment in source.experiments)

    def draw(self, results: Results, command: str) -> Figure:
        """Draw the figure, with the command that made it in the caption."""
        panels = {
            title: {name: self.curve(source.draw(results)) for name, source in panel.items()}
            for title, panel in self.panels.items()
        }
        sources: dict[str, list[Source]] = {}
        for panel in self.panels.values():
            for name, source in panel.items():
                sources.setdefault(name, []).append(source)
        controllers = {name: controller_of(each) for name, each in sources.items()}
        caption = caption_of(self, results, command)
        return curve_panels(panels, self.axes, caption, controllers)


def caption_of(
    figure: PaperFigure, results: Results, command: str, word: str = "episodes"
) -> Caption:
    """The caption of a figure of a paper; all experiments have as many episodes."""
    n = len(next(iter(results.values())))
    text = " ".join(part for part in (figure.caption, figure.reading) if part)
    return Caption(text, f"n = {n} {word} each", command, n=n)


def controller_of(sources: Sequence[Source]) -> str:
    """The controller behind sources; without parameters where these differ among them."""
    names = {each.controller for source in sources for each in source.experiments}
    return min(names) if len(names) == 1 else min(names).partition(":")[0]


def time_of_each_robot(episodes: Sequence[ForagingEpisode]) -> Curve:
    """Time until k robots had visited both areas [s]; else the whole episode."""
    n_robots = episodes[0].n_robots
    times = np.array(
        [
            [*episode.recruited_at_s]
            + [episode.duration_s] * (n_robots - len(episode.recruited_at_s))
            for episode in episodes
        ]
    )
    return Curve(np.arange(1.0, n_robots + 1.0), times)


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
    """Write every figure to a folder in a page style, in each format."""
    folder.mkdir(parents=True, exist_ok=True)
    for paper_figure in figures:
        with page_style(style):
            figure = paper_figure.draw(results, command)
            for ending in ENDINGS[style]:
                file = folder / f"{paper_figure.name}{ending}"
                save_figure(figure, file, command, paper_figure.caption)
