"""Episodes: their results, and how a task measures them."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from functools import partial
from typing import Any, Protocol

from swarm_forage_env.arrays import Array

MeasuredLoop = Any
"""A `Loop` or a `DeviceLoop`, which this module cannot import."""


class EpisodeMeter(Protocol):
    """Measures a block of worlds while it runs."""

    def next_sample(self, tick: int) -> int:
        """Return the next tick after this one at which something is measured."""

    def sample(self, tick: int) -> None:
        """Measure the worlds after this tick; the first tick is 1."""

    def results(self) -> list[dict[str, object]]:
        """Return the metrics of each world by name; the episodes must be over."""


@dataclass(frozen=True)
class EpisodeKind:
    """Result class, meter and metrics of the episodes of a task."""

    episode: type[Any]
    """Frozen dataclass: the identity of an episode (scenario, controller, seed, physics, n_robots,
    duration_s), its metrics, and the computing time wall_s."""
    meter: Callable[[MeasuredLoop], EpisodeMeter]
    """Creates the meter of a control loop."""
    score: str
    """Metric by which controllers are compared."""
    score_words: str
    """Description of the score for readers."""
    columns: Mapping[str, tuple[str, float]]
    """Metrics in the order of the table, each with its heading and the factor to its unit."""
    sometimes_words: str = ""
    """Heading of the table of the metrics that only some episodes have."""

    @property
    def sometimes(self) -> tuple[str, ...]:
        """Metrics of episodes of some scenarios, None in all others; they have a separate table,
        and datasets of earlier releases lack them."""
        return tuple(each.name for each in fields(self.episode) if each.default is None)

    @property
    def series(self) -> tuple[str, ...]:
        """Fields of an episode that are lists."""
        return tuple(each.name for each in fields(self.episode) if each.default == ())

    def axis(self, metric: str) -> str:
        """Return the heading of a metric on one line, for an axis."""
        return self.columns[metric][0].replace("-\n", "").replace("\n", " ")


@dataclass(frozen=True)
class EpisodeHeader:
    """Identity of an episode."""

    scenario: str
    controller: str
    """Controller as the user named it: `ssgiff`, or `ssgiff:beta=0.02`."""
    seed: int
    """Seed of the world; all controllers get the same world from one seed."""
    physics: str
    """Engine that moved the robots."""
    n_robots: int
    duration_s: float
    """Length of the episode [s]."""


@dataclass(frozen=True, kw_only=True)
class Episode(EpisodeHeader):
    """The results of an episode; a task adds its metrics by a subclass."""

    wall_s: float
    """Computing time [s]: an equal share of that of the block of the episode."""


Judge = Callable[[Any], Mapping[str, Array]]
"""Computes the metrics of finished worlds, with one value for each world. NaN: the world has none,
and the field of the episode is then `float | None`."""


class FinalMeter:
    """Meter that computes metrics from the final state of the worlds."""

    def __init__(self, judge: Judge, loop: MeasuredLoop) -> None:
        self._judge, self._loop = judge, loop

    def next_sample(self, tick: int) -> int:
        """Return the last tick, as nothing is measured before it."""
        return int(self._loop.world.scenario.n_ticks)

    def sample(self, tick: int) -> None:
        """Do nothing; `results` reads the final state."""

    def results(self) -> list[dict[str, object]]:
        """Return the metrics of each world."""
        metrics = self._judge(self._loop.download().world)
        columns = (
            [None if math.isnan(value) else value for value in each.tolist()]
            for each in metrics.values()
        )
        return [dict(zip(metrics, row, strict=True)) for row in zip(*columns, strict=True)]


def judged_at_the_end(judge: Judge) -> Callable[[MeasuredLoop], EpisodeMeter]:
    """Return a function that creates a `FinalMeter` for a loop."""
    return partial(FinalMeter, judge)
