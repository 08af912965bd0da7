"""Experiments of a paper, each a controller on a scenario, and the samples drawn from them."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from baselines.evaluation.console import of_option
from baselines.evaluation.experiment_config import (
    ExperimentConfig,
    find_layered_controller,
    parse_settings,
)
from swarm_forage_env.foraging.episode import ForagingEpisode
from swarm_forage_env.scenarios import find_scenario
from swarm_forage_env.task import task_of

Metric = Callable[[ForagingEpisode], float]  # value of an episode
FOLDS = 2  # groups of seeds of a cross-validation


class UsesFields:
    """Base of a dataclass whose fields hold experiments: single ones, tuples or mappings."""

    @property
    def experiments(self) -> "tuple[Experiment, ...]":
        """The experiments whose episodes are used."""
        return tuple(_experiments_in(vars(self)))


def _experiments_in(held: object) -> "Iterator[Experiment]":
    if hasattr(held, "experiments"):
        yield from held.experiments
    elif isinstance(held, Mapping | tuple):
        for each in held.values() if isinstance(held, Mapping) else held:
            yield from _experiments_in(each)


@dataclass(frozen=True)
class Experiment:
    """One experiment of a paper: a controller on a scenario."""

    scenario: str
    controller: str
    settings: tuple[str, ...] = ()  # changes of the scenario: `task.n_robots=5`
    physics: str | None = None  # its own engine; None: that of the others

    @property
    def experiments(self) -> tuple["Experiment", ...]:
        """This experiment alone, as a source of samples."""
        return (self,)

    def draw(self, results: "Results") -> list[ForagingEpisode]:
        """Return the episodes of this experiment."""
        return list(results[self])

    def configuration(self, physics: str | None, settings: Sequence[str] = ()) -> ExperimentConfig:
        """Return the configuration of its episodes; settings change the scenario."""
        changes = parse_settings(settings) | parse_settings(self.settings)
        with of_option("--set: "):
            scenario = find_scenario(self.scenario, changes)
        engine = self.physics or physics or task_of(scenario).physics
        controller = find_layered_controller(self.controller)
        return ExperimentConfig(self.controller, scenario, controller, engine)


Results = Mapping[Experiment, Sequence[ForagingEpisode]]
"""Episodes of every experiment, all with the same seeds in the same order."""


@dataclass(frozen=True)
class CrossValidatedBest:
    """Best parameter by two-fold cross-validation over seeds, to avoid selection bias.

    The seeds are split into two halves; the best experiment of each half is scored on the other
    half. Every seed is thus scored once, by an experiment that was chosen without it.
    """

    experiments: tuple[Experiment, ...]

    def draw(self, results: Results) -> list[ForagingEpisode]:
        """Return for each seed the episode of the experiment that is best on the other half."""
        n_seeds = len(results[self.experiments[0]])
        chosen = [self.experiments[index] for index in self.choices(results)]
        return [results[chosen[seed % len(chosen)]][seed] for seed in range(n_seeds)]

    def choices(self, results: Results) -> list[int]:
        """Return for each half the index of the experiment that is best on the other half."""
        score = np.array([sample(results, each, round_trips) for each in self.experiments])
        if score.shape[1] < FOLDS:
            return [int(score.sum(axis=1).argmax())]
        fold = np.arange(score.shape[1]) % FOLDS
        return [int(score[:, fold != each].mean(axis=1).argmax()) for each in range(FOLDS)]


Source = Experiment | CrossValidatedBest
"""Source of one episode for each seed, in the order of the seeds."""


@dataclass(frozen=True)
class Pool(UsesFields):
    """Several sources taken together: the value of a seed is its mean over them."""

    sources: tuple[Source, ...]


def sample(results: Results, source: Source | Pool, metric: Metric) -> list[float]:
    """Return the metric of a source for each seed, in the order of the seeds."""
    sources = source.sources if isinstance(source, Pool) else (source,)
    drawn = [[metric(episode) for episode in each.draw(results)] for each in sources]
    return [float(value) for value in np.mean(drawn, axis=0)]


def present(results: Results, source: Source | Pool, metric: Metric) -> list[float]:
    """Return the metric of a source for each seed that has one: NaN is left out."""
    return [value for value in sample(results, source, metric) if not math.isnan(value)]


def round_trips(episode: ForagingEpisode) -> float:
    """Metric: round trips of all robots."""
    return float(episode.round_trips)


def on_path(episode: ForagingEpisode) -> float:
    """Metric: share of the robots on the path in the second half of the episode."""
    return episode.on_path_share


def recruitment_time(episode: ForagingEpisode) -> float:
    """Metric: time until all robots had visited both areas [s], at most the duration."""
    time = episode.recruitment_time_s
    return episode.duration_s if time is None else time


def not_all_recruited(episode: ForagingEpisode) -> float:
    """Metric: 1 if some robot had not visited both areas by the end, else 0."""
    return float(episode.recruitment_time_s is None)
