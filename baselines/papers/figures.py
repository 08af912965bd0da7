"""Figures as the papers have them: what is drawn from which cells, and how it is captioned."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np
from matplotlib.figure import Figure

from baselines.evaluation.curves import BANDS, Curve, curve_panels
from baselines.evaluation.episode import Episode
from baselines.evaluation.panels import BOXES, box_panels
from baselines.evaluation.plots import save
from baselines.papers.cells import Cell, Metric, Results, Source, round_trips

ENDINGS = (".png", ".svg")
"""Files of each figure."""


class Picture(Protocol):
    """A figure of a paper."""

    @property
    def name(self) -> str:
        """Of its file: `tr14`."""
        ...

    @property
    def caption(self) -> str:
        """What it shows."""
        ...

    @property
    def cells(self) -> tuple[Cell, ...]:
        """The cells it needs."""
        ...

    def draw(self, results: Results, command: str) -> Figure:
        """Draw it; the command that made it stands below."""
        ...


@dataclass(frozen=True)
class Boxes:
    """A boxplot of a number of each episode, a panel for each setup."""

    name: str
    caption: str
    axes: tuple[str, str]
    """Names of x and y."""
    panels: Mapping[str, Mapping[str, Mapping[str, Source]]]
    """Sources by panel, tick of x and series."""
    metric: Metric = round_trips
    """NaN leaves an episode out."""

    @property
    def cells(self) -> tuple[Cell, ...]:
        """The cells it needs."""
        ticks = [tick for panel in self.panels.values() for tick in panel.values()]
        return tuple(cell for tick in ticks for source in tick.values() for cell in source.cells)

    def draw(self, results: Results, command: str) -> Figure:
        """Draw it; the command that made it stands below."""

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
        return box_panels(panels, self.axes, f"{self.caption} {BOXES} {command}")


@dataclass(frozen=True)
class Curves:
    """Mean curves over time or number of robots, a panel for each setup."""

    name: str
    caption: str
    axes: tuple[str, str]
    """Names of x and y."""
    panels: Mapping[str, Mapping[str, Source]]
    """Sources by panel and series."""
    curve: Callable[[Sequence[Episode]], Curve]

    @property
    def cells(self) -> tuple[Cell, ...]:
        """The cells it needs."""
        sources = [source for panel in self.panels.values() for source in panel.values()]
        return tuple(cell for source in sources for cell in source.cells)

    def draw(self, results: Results, command: str) -> Figure:
        """Draw it; the command that made it stands below."""
        panels = {
            title: {name: self.curve(source.draw(results)) for name, source in panel.items()}
            for title, panel in self.panels.items()
        }
        episodes = len(next(iter(results.values())))
        return curve_panels(
            panels, self.axes, f"{self.caption} {BANDS} n = {episodes} episodes. {command}"
        )


def time_of_each_robot(episodes: Sequence[Episode]) -> Curve:
    """When k robots had visited both areas [s]; the whole episode where fewer ever had."""
    n_robots = episodes[0].n_robots
    times = np.array(
        [
            [*episode.recruited_at_s]
            + [episode.duration_s] * (n_robots - len(episode.recruited_at_s))
            for episode in episodes
        ]
    )
    return Curve(np.arange(1.0, n_robots + 1.0), times)


def recruitment_if_finished(episode: Episode) -> float:
    """Time until all robots had visited both areas [s]; NaN if not all did."""
    time = episode.recruitment_time_s
    return math.nan if time is None else time


def write_figures(
    pictures: Sequence[Picture], results: Results, folder: Path, command: str
) -> None:
    """Write every figure to the folder, in each format."""
    folder.mkdir(parents=True, exist_ok=True)
    for picture in pictures:
        figure = picture.draw(results, command)
        for ending in ENDINGS:
            save(figure, folder / f"{picture.name}{ending}", command, picture.caption)
