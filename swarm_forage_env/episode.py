"""Episodes: what a task is judged by at the end of one, whoever runs it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from functools import partial
from typing import Any, Protocol

from swarm_forage_env.arrays import Array

MeasuredLoop = Any
"""A `Loop` or a `DeviceLoop`, from floors above."""


class EpisodeMeter(Protocol):
    """Measures a block of worlds while it runs."""

    def next_sample(self, tick: int) -> int:
        """The next tick after this one with which something is to be measured."""

    def sample(self, tick: int) -> None:
        """Look at the worlds after this tick, 1 being the first."""

    def results(self) -> list[dict[str, object]]:
        """What each world came to, by the names of its metrics; the worlds are over."""


@dataclass(frozen=True)
class EpisodeKind:
    """What an episode of a task is, and what is compared."""

    episode: type[Any]
    """A frozen dataclass: which episode it was (scenario, controller, seed, physics, n_robots,
    duration_s), its metrics, and the computing time wall_s."""
    meter: Callable[[MeasuredLoop], EpisodeMeter]
    """Makes what measures the worlds of a control loop."""
    score: str
    """Metric by which controllers are compared."""
    score_words: str
    """The same for a reader."""
    columns: Mapping[str, tuple[str, float]]
    """Metrics in the order of the table, with their headings and the factor to their units."""
    sometimes_words: str = ""
    """The heading of the table of the metrics that only some episodes have."""

    @property
    def sometimes(self) -> tuple[str, ...]:
        """Fields that only episodes of some scenarios have, None in all others, which stand in a
        table of their own; datasets of earlier releases lack them."""
        return tuple(each.name for each in fields(self.episode) if each.default is None)

    @property
    def series(self) -> tuple[str, ...]:
        """Fields of an episode that are lists."""
        return tuple(each.name for each in fields(self.episode) if each.default == ())

    def axis(self, metric: str) -> str:
        """The heading of a metric in one line, for an axis."""
        return self.columns[metric][0].replace("-\n", "").replace("\n", " ")


@dataclass(frozen=True)
class EpisodeHeader:
    """Which episode it was."""

    scenario: str
    controller: str
    """The controller as the user named it: `ssgiff`, or `ssgiff:beta=0.02`."""
    seed: int
    """Seed of the world; controllers under one seed meet the same world."""
    physics: str
    """Engine that moved the robots."""
    n_robots: int
    duration_s: float
    """Length of the episode [s]."""


@dataclass(frozen=True, kw_only=True)
class Episode(EpisodeHeader):
    """The results of an episode; a task adds its metrics by a subclass."""

    wall_s: float
    """Computing time: an equal share of that of the block the episode ran in [s]."""


Judge = Callable[[Any], Mapping[str, Array]]
"""What worlds that are over came to: of each metric a number for each world."""


class FinalMeter:
    """Judges worlds by how they stand when they are over."""

    def __init__(self, judge: Judge, loop: MeasuredLoop) -> None:
        self._judge, self._loop = judge, loop

    def next_sample(self, tick: int) -> int:
        """There is nothing to measure on the way."""
        return int(self._loop.world.scenario.n_ticks)

    def sample(self, tick: int) -> None:
        """All is read in `results`."""

    def results(self) -> list[dict[str, object]]:
        """The metrics of each world."""
        metrics = self._judge(self._loop.download().world)
        columns = (each.tolist() for each in metrics.values())
        return [dict(zip(metrics, row, strict=True)) for row in zip(*columns, strict=True)]


def judged_at_the_end(judge: Judge) -> Callable[[MeasuredLoop], EpisodeMeter]:
    """Makes what judges worlds by how they stand when they are over."""
    return partial(FinalMeter, judge)
