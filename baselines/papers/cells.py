"""Cells: a controller on a scenario, and what a claim or a figure draws its episodes from."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from baselines.evaluation.configuration import Configuration, find_recipe, parse_settings
from baselines.evaluation.episode import Episode
from swarm_forage_env.loop import default_physics
from swarm_forage_env.scenarios import find_scenario

Metric = Callable[[Episode], float]
"""A number of an episode."""

FOLDS = 2
"""Groups of seeds: what is chosen on one is scored on the others."""


@dataclass(frozen=True)
class Cell:
    """A controller on a scenario: one box of a boxplot."""

    scenario: str
    controller: str
    settings: tuple[str, ...] = ()
    """Numbers of the scenario to change: `task.n_robots=5`."""

    @property
    def cells(self) -> tuple["Cell", ...]:
        """Itself, all that it needs."""
        return (self,)

    def draw(self, results: "Results") -> list[Episode]:
        """Its episodes."""
        return list(results[self])

    def configuration(self, physics: str | None, settings: Sequence[str] = ()) -> Configuration:
        """What fixes its episodes but for their seeds; settings change numbers of the scenario."""
        changes = parse_settings(settings) | parse_settings(self.settings)
        scenario = find_scenario(self.scenario, changes)
        engine = physics or default_physics(scenario)
        return Configuration(self.controller, scenario, find_recipe(self.controller), engine)


Results = Mapping[Cell, Sequence[Episode]]
"""The episodes of every cell, all under the same seeds in the same order."""


class Source(Protocol):
    """Where a sample comes from."""

    @property
    def cells(self) -> tuple[Cell, ...]:
        """The cells it needs."""
        ...

    def draw(self, results: Results) -> list[Episode]:
        """One episode for each seed, in the order of the seeds."""
        ...


@dataclass(frozen=True)
class Best:
    """The cell with the most round trips, without the flattery of choosing among noisy scores.

    The seeds are split in two halves; the best cell of one half is scored on the other half,
    and the other way round. So every seed is scored once, by a cell chosen without it.
    """

    cells: tuple[Cell, ...]

    def draw(self, results: Results) -> list[Episode]:
        """For each seed, the episode of the cell that is best on the other half."""
        n_seeds = len(results[self.cells[0]])
        chosen = [self.cells[index] for index in self.choices(results)]
        return [results[chosen[seed % len(chosen)]][seed] for seed in range(n_seeds)]

    def choices(self, results: Results) -> list[int]:
        """For each half, the index of the cell that scores it; of all seeds if there is one."""
        score = np.array([sample(results, cell, round_trips) for cell in self.cells])
        n_seeds = score.shape[1]
        if n_seeds < FOLDS:
            return [int(score.sum(axis=1).argmax())]
        fold = np.arange(n_seeds) % FOLDS
        return [int(score[:, fold != each].mean(axis=1).argmax()) for each in range(FOLDS)]


@dataclass(frozen=True)
class Pool:
    """Several sources as one: a seed counts with its mean over them."""

    sources: tuple[Source, ...]

    @property
    def cells(self) -> tuple[Cell, ...]:
        """The cells of all."""
        return tuple(cell for source in self.sources for cell in source.cells)


def sample(results: Results, source: Source | Pool, metric: Metric) -> list[float]:
    """A number for each seed, in the order of the seeds."""
    sources = source.sources if isinstance(source, Pool) else (source,)
    drawn = [[metric(episode) for episode in each.draw(results)] for each in sources]
    return [float(value) for value in np.mean(drawn, axis=0)]


def round_trips(episode: Episode) -> float:
    """Round trips of all robots."""
    return float(episode.round_trips)


def on_path(episode: Episode) -> float:
    """Share of the robots on the path in the second half."""
    return episode.on_path_share


def recruitment(episode: Episode) -> float:
    """Time until all robots had visited both areas [s]; the whole episode if not all did."""
    time = episode.recruitment_time_s
    return episode.duration_s if time is None else time


def unfinished(episode: Episode) -> float:
    """1 if some robot had not visited both areas by the end, else 0."""
    return float(episode.recruitment_time_s is None)
