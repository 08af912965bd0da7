"""Targets: what the TR publishes on social odometry, and the score of a set of values.

The score is a sum of terms, one for each target, none below zero:

    equal     w |ln(ours / published)|
    at most   w max(0, ln(ours / published))
    at least  w max(0, ln(published / ours))

so a number 20 % off costs about as much in any arena, and a bound that holds costs nothing.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from baselines.evaluation.statistics import Estimate, compare, mean_interval
from swarm_forage_env.foraging.episode import ForagingEpisode

Relation = Literal["equal", "at most", "at least"]

FARTHEST = math.log(20.0)
"""No ratio counts as farther off than 20; so that of zero round trips has a logarithm too."""

SGIFF = ("ssgiff:beta=0.01", "ssgiff:beta=0.001")
"""The best of these stands for the best beta: 1e-2 in es1 and es2, 1e-3 in es3 (TR 6.1.2)."""

CONTROLLERS = ("nc", "ssgikf", "dsgikf", *SGIFF)
"""Run in every arena."""

ArenaEpisodes = Mapping[tuple[str, str], Sequence[ForagingEpisode]]
"""The episodes of each arena and controller."""


@dataclass(frozen=True)
class Target:
    """A published number or bound, with its weight in the score."""

    quantity: Literal["round_trips", "on_path_share", "recruitment_time_s"]
    arena: str
    controllers: tuple[str, ...]
    """Of several, the one with the greatest mean counts."""

    kind: Relation
    published: float
    weight: float
    over: str = ""
    """Not the number itself counts, but its ratio to that of this controller."""

    source: str = "TR 6.1.2"

    @property
    def name(self) -> str:
        """The quantity in a few words, for a table."""
        best = "best ssgiff" if self.controllers == SGIFF else " ".join(self.controllers)
        words = self.quantity.removesuffix("_s").replace("_", " ")
        return f"{words}, {best}" + (f" / {self.over}" if self.over else "")

    @property
    def bound(self) -> str:
        """The published number, with a sign where it is a bound."""
        sign = {"equal": "", "at most": "<= ", "at least": ">= "}[self.kind]
        return f"{sign}{self.published:g}"


def _of_arena(arena: str) -> tuple[Target, ...]:
    """The targets that are alike in all arenas.

    The TR says that SGIFF is better than SGIKF, and that the double filter is worse than the
    single one, but not by how much. Chosen here: by 5 % at least, so that 30 episodes can show
    it; and the double filter by not more than half.
    """
    return (
        Target("round_trips", arena, SGIFF, "at least", 1.05, 1.0, "ssgikf"),
        Target("round_trips", arena, ("dsgikf",), "at most", 0.95, 0.5, "ssgikf"),
        Target("round_trips", arena, ("dsgikf",), "at least", 0.5, 0.25, "ssgikf"),
        Target("on_path_share", arena, ("ssgikf",), "at least", 0.5, 0.5, source="TR 6.1.3"),
        Target("on_path_share", arena, ("ssgikf",), "at most", 0.7, 0.5, source="TR 6.1.3"),
        Target("on_path_share", arena, ("nc",), "at most", 0.2, 0.5, source="TR 6.1.3"),
    )


TARGETS = (
    Target("round_trips", "es1", ("nc",), "equal", 60.0, 1.0),
    Target("round_trips", "es1", ("ssgikf",), "equal", 150.0, 1.0),
    Target("round_trips", "es1", SGIFF, "equal", 170.0, 1.0, source="TR 6.2"),
    Target("recruitment_time_s", "es1", ("nc",), "equal", 4.0, 0.25, "ssgikf", "TR 6.1.1"),
    *_of_arena("es1"),
    Target("round_trips", "es2", ("nc",), "at most", 50.0, 1.0),
    Target("round_trips", "es2", ("ssgikf",), "equal", 1400.0, 1.0),
    Target("recruitment_time_s", "es2", ("nc",), "equal", 4.0, 0.25, "ssgikf", "TR 6.1.1"),
    *_of_arena("es2"),
    Target("round_trips", "es3", ("nc",), "at most", 50.0, 1.0),
    Target("round_trips", "es3", ("ssgikf",), "equal", 2000.0, 1.0),
    Target("recruitment_time_s", "es3", ("nc",), "at least", 7200.0, 0.25, source="TR 6.1.1"),
    *_of_arena("es3"),
)
"""Every published result that a set of values is judged by."""


def of_arenas(arenas: Sequence[str]) -> list[Target]:
    """The targets of these arenas."""
    return [target for target in TARGETS if target.arena in arenas]


def term(target: Target, ours: float) -> float:
    """The term that a measured number adds to the score.

    >>> target = Target("round_trips", "es2", ("nc",), "at most", 50.0, 1.0)
    >>> term(target, 40.0)
    0.0

    A ratio to zero says nothing, and costs as much as can be.
    """
    if math.isinf(ours):
        return target.weight * FARTHEST
    off = math.log(ours / target.published) if ours > 0.0 else -FARTHEST
    off = min(max(off, -FARTHEST), FARTHEST)
    wrong = {"equal": abs(off), "at most": max(0.0, off), "at least": max(0.0, -off)}
    return target.weight * wrong[target.kind]


def score(measured: Mapping[Target, float]) -> float:
    """The score of measured targets, a sum of terms: the smaller, the nearer."""
    return math.fsum(term(target, ours) for target, ours in measured.items())


def measure(target: Target, episodes: ArenaEpisodes) -> float:
    """The measured number of a target: a mean, or a ratio of means.

    Infinite for a ratio to zero.
    """
    ours = _mean(_best(target, episodes))
    if not target.over:
        return ours
    base = _mean(_sample(episodes[target.arena, target.over], target.quantity))
    return ours / base if base else math.inf


def estimate(target: Target, episodes: ArenaEpisodes) -> Estimate | None:
    """The measured number of a target with its 95 % interval; None for a ratio to zero."""
    values = _best(target, episodes)
    if not target.over:
        return mean_interval(values)
    return compare(values, _sample(episodes[target.arena, target.over], target.quantity)).ratio


def _best(target: Target, episodes: ArenaEpisodes) -> list[float]:
    samples = [
        _sample(episodes[target.arena, controller], target.quantity)
        for controller in target.controllers
    ]
    return max(samples, key=_mean)


def _sample(episodes: Sequence[ForagingEpisode], quantity: str) -> list[float]:
    """A number of each episode; a recruitment that did not end counts as the whole episode."""
    found = ((getattr(episode, quantity), episode.duration_s) for episode in episodes)
    return [float(whole if value is None else value) for value, whole in found]


def _mean(values: Sequence[float]) -> float:
    return math.fsum(values) / len(values)
