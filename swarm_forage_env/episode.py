"""Episodes: what a task is judged by at the end of one, whoever runs it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol


class EpisodeMeter(Protocol):
    """Measures a block of worlds while it runs."""

    def next_sample(self, tick: int) -> int:
        """The next tick after this one with which something is to be measured."""
        ...

    def sample(self, tick: int) -> None:
        """Look at the worlds after this tick, 1 being the first."""
        ...

    def results(self) -> list[dict[str, Any]]:
        """What each world came to, by the names of its metrics; the worlds are over."""
        ...


@dataclass(frozen=True)
class EpisodeKind:
    """What an episode of a task is, and what is compared."""

    episode: type[Any]
    """A frozen dataclass: which episode it was (scenario, controller, seed, physics, n_robots,
    duration_s), its metrics, and the computing time wall_s."""

    meter: Callable[[Any], EpisodeMeter]
    """Makes what measures the worlds of a control loop."""

    score: str
    """Metric by which controllers are compared."""

    score_words: str
    """The same for a reader."""

    columns: Mapping[str, tuple[str, float]]
    """Metrics in the order of the table, with their headings and the factor to their units."""

    sometimes: tuple[str, ...] = ()
    """Fields that only episodes of some scenarios have, None in all others: they stand in
    a table of their own where an episode has them, and datasets of earlier releases lack them."""

    sometimes_words: str = ""
    """The heading of the table of those."""

    series: tuple[str, ...] = ()
    """Fields of an episode that are lists."""

    def axis(self, metric: str) -> str:
        """The heading of a metric in one line, for an axis."""
        return self.columns[metric][0].replace("-\n", "").replace("\n", " ")
