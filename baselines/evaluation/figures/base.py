"""What a kind of figure is asked for, and the registry of the kinds."""

import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

from matplotlib.figure import Figure

from baselines.evaluation.groups import Group, read_groups
from baselines.evaluation.kinds import FORAGING
from swarm_forage_env.errors import ConfigError, UnknownNameError
from swarm_forage_env.registry import Registry


@dataclass(frozen=True)
class Wish:
    """What a user asks `plot` for."""

    kind: str
    sources: Sequence[str]
    """Folders of datasets; for some kinds something else."""
    scenarios: Sequence[str] = ()
    controllers: Sequence[str] = ()
    """Empty: all that there are."""
    metric: str | None = None
    """None: the score."""
    x: str | None = None
    """None: the one number that varies."""
    seed: int | None = None
    """None: the first."""

    @property
    def options(self) -> dict[str, object]:
        """The options that are given, by name."""
        given = {
            "scenario": self.scenarios,
            "controller": self.controllers,
            "metric": self.metric,
            "x": self.x,
            "seed": self.seed,
        }
        return {name: value for name, value in given.items() if value not in ((), None)}

    @property
    def command(self) -> str:
        """The command that draws the same figure again."""
        words = ["swarm-forage", "plot", self.kind, *map(str, self.sources)]
        for name, value in self.options.items():
            values = value if isinstance(value, tuple) else (value,)
            words += [word for each in values for word in (f"--{name}", str(each))]
        return shlex.join(words)

    @cached_property
    def groups(self) -> list[Group]:
        """The groups in the datasets, all of one kind of task.

        ConfigError for sources that are no such datasets.
        """
        found = read_groups(self.sources, self.scenarios, self.controllers)
        if len({group.kind.score for group in found}) > 1:
            raise ConfigError(
                f"{', '.join(self.sources)}: holds episodes of foraging and of waypoints; choose"
                " with --scenario"
            )
        return found

    @property
    def foraging(self) -> list[Group]:
        """The same for what only foraging has; ConfigError if they are of waypoints."""
        found = self.groups
        if found[0].kind is not FORAGING:
            raise ConfigError(
                f"{', '.join(self.sources)}: episodes of waypoints have no nest and prey, which"
                f" '{self.kind}' shows; boxplot, curve and table do for them"
            )
        return found

    @property
    def shown(self) -> str:
        """The metric that is shown; UnknownNameError if these episodes have none of that name."""
        kind = self.groups[0].kind
        metric = self.metric or kind.score
        if metric not in kind.columns:
            raise UnknownNameError("metric", metric, kind.columns)
        return metric

    def caption(self, text: str) -> str:
        """What the figure shows, then the command that makes it."""
        return f"{text} {self.command}"


class FigureKind(Protocol):
    """A kind of figure."""

    options: frozenset[str]
    """Options that it has."""

    def draw(self, wish: Wish) -> Figure:
        """Draw it; ConfigError if the sources lack what it needs."""
        ...


FIGURES: Registry[FigureKind] = Registry("kind of figure")
"""The kinds of figures by name."""

SELECTION = frozenset({"scenario", "controller"})
"""Options of every kind that reads a dataset."""


def check_options(wish: Wish) -> None:
    """ConfigError for an option that the kind does not have."""
    for name in wish.options:
        if name not in FIGURES[wish.kind].options:
            having = sorted(kind for kind in FIGURES if name in FIGURES[kind].options)
            raise ConfigError(
                f"--{name}: '{wish.kind}' has no such option; it is of {', '.join(having)}"
            )


def sample(group: Group, metric: str) -> list[float]:
    """The metric of each episode in the units of its axis; those without one are left out."""
    factor = group.kind.columns[metric][1]
    values = [getattr(episode, metric) for episode in group.episodes]
    return [factor * value for value in values if value is not None]


def by_setup(groups: Sequence[Group]) -> dict[str, list[Group]]:
    """The groups of each setup, in their order."""
    setups: dict[str, list[Group]] = {}
    for group in groups:
        setups.setdefault(group.setup(), []).append(group)
    return setups


def size_of(groups: Sequence[Group]) -> str:
    """Robots and length of the episodes, where all have the same."""
    robots = {group.episodes[0].n_robots for group in groups}
    lengths = {group.episodes[0].duration_s for group in groups}
    parts = [f"{min(robots)} robots"] if len(robots) == 1 else []
    parts += [f"{min(lengths):g} s"] if len(lengths) == 1 else []
    return f"{', '.join(parts)}. " if parts else ""


def counted(groups: Sequence[Group]) -> str:
    """How many episodes stand behind each group, and the code that ran them."""
    sizes = {len(group.episodes) for group in groups}
    n = f"{min(sizes)}" if len(sizes) == 1 else f"{min(sizes)} to {max(sizes)}"
    codes = ", ".join(sorted({group.code for group in groups}))
    return f"n = {n} episodes each, code {codes}."
