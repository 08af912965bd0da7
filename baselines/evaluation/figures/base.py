"""Options of the command `plot`, and the registry of the kinds of figures."""

import shlex
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

from matplotlib.figure import Figure

from baselines.evaluation.console import count_noun
from baselines.evaluation.dataset_reader import EpisodeGroup, read_groups
from baselines.evaluation.episode import present_values
from baselines.evaluation.figure_page import Caption
from swarm_forage_env.errors import ConfigError, UnknownNameError
from swarm_forage_env.registry import Registry


@dataclass(frozen=True)
class PlotOptions:
    """Options of the command `plot`."""

    kind: str
    sources: Sequence[str]  # folders of datasets; cards or controllers for some kinds
    scenarios: Sequence[str] = ()
    controllers: Sequence[str] = ()  # empty: all
    metric: str | None = None  # None: the score
    x: str | None = None  # None: the only setting that varies
    seed: int | None = None  # None: the first
    style: str = "screen"  # page style
    with_caption: bool = False  # draw the whole caption

    @property
    def choices(self) -> dict[str, object]:
        """Options set by the user, by name."""
        chosen: dict[str, object] = {"scenario": self.scenarios, "controller": self.controllers}
        chosen |= {"metric": self.metric, "x": self.x, "seed": self.seed}
        return {name: value for name, value in chosen.items() if value not in ((), None)}

    @property
    def command(self) -> str:
        """Command line that draws the same figure again."""
        words = ["swarm-forage", "plot", self.kind, *map(str, self.sources)]
        for name, value in self.choices.items():
            values = value if isinstance(value, tuple) else (value,)
            words += [word for each in values for word in (f"--{name}", str(each))]
        words += [] if self.style == "screen" else ["--style", self.style]
        words += ["--caption"] if self.with_caption else []
        return shlex.join(words)

    @cached_property
    def groups(self) -> list[EpisodeGroup]:
        """Episode groups in the datasets; ConfigError unless all are of one task."""
        groups = read_groups(self.sources, self.scenarios, self.controllers)
        if len(tasks := sorted({group.task.name for group in groups})) > 1:
            raise ConfigError(
                f"{', '.join(self.sources)}: holds episodes of {' and of '.join(tasks)}; choose"
                " one with --scenario"
            )
        return groups

    @property
    def foraging_groups(self) -> list[EpisodeGroup]:
        """Episode groups of foraging; ConfigError if they are of another task."""
        task = self.groups[0].task.name
        if task != "foraging":
            raise ConfigError(
                f"{', '.join(self.sources)}: episodes of {task} have no nest and prey, which"
                f" '{self.kind}' shows; use boxplot, curve or table"
            )
        return self.groups

    @property
    def shown_metric(self) -> str:
        """Metric to show; UnknownNameError if the episodes do not have it."""
        kind = self.groups[0].kind
        metric = self.metric or kind.score
        if metric not in kind.columns:
            raise UnknownNameError("metric", metric, kind.columns)
        return metric

    def caption(
        self, text: str, groups: Sequence[EpisodeGroup] = (), note: str = "", metric: str = ""
    ) -> Caption:
        """Return the caption; without `note`, it counts the episodes and robots of the groups."""
        return Caption(text, note or counted(groups, metric), self.command, codes(groups))


Draw = Callable[[PlotOptions], Figure]
"""Function that draws a figure; ConfigError if the sources lack what it needs."""


@dataclass(frozen=True)
class FigureKind:
    """Kind of figure: the function that draws it, and its options."""

    draw: Draw
    options: tuple[str, ...]


FIGURES: Registry[FigureKind] = Registry("kind of figure")  # the kinds of figures by name
SELECTION = "scenario", "controller"  # options of every kind that reads a dataset


def figure(name: str, *options: str) -> Callable[[Draw], Draw]:
    """Register the decorated function as a kind of figure with these options."""

    def enter(draw: Draw) -> Draw:
        FIGURES.register(name)(FigureKind(draw, options))
        return draw

    return enter


def check_options(options: PlotOptions) -> None:
    """Raise ConfigError for an option that the kind of figure does not have."""
    for name in options.choices:
        if name not in FIGURES[options.kind].options:
            having = sorted(kind for kind in FIGURES if name in FIGURES[kind].options)
            raise ConfigError(
                f"--{name}: '{options.kind}' has no such option; it belongs to {', '.join(having)}"
            )


def sample(group: EpisodeGroup, metric: str) -> list[float]:
    """Return the metric of each episode in the units of its axis, without missing values."""
    return present_values(group.episodes, metric, group.kind.columns[metric][1])


def by_setup(groups: Sequence[EpisodeGroup]) -> dict[str, list[EpisodeGroup]]:
    """Group the episode groups by setup, in their order."""
    setups: dict[str, list[EpisodeGroup]] = {}
    for group in groups:
        setups.setdefault(group.setup(), []).append(group)
    return setups


def counted(groups: Sequence[EpisodeGroup], metric: str = "") -> str:
    """The note: number of episodes of each group, and of those with the metric where some lack it;
    robots and length, where all have the same."""
    if not groups:
        return ""
    robots = {group.episodes[0].n_robots for group in groups}
    lengths = {group.episodes[0].duration_s for group in groups}
    parts = [count_noun(min(robots), "robot")] if len(robots) == 1 else []
    parts += [f"{min(lengths):g} s"] if len(lengths) == 1 else []
    sizes = [len(group.episodes) for group in groups]
    parts.append(f"n = {_span(sizes)} episodes each")
    having = [len(sample(group, metric)) for group in groups] if metric else sizes
    parts += [] if having == sizes else [f"{_span(having)} of them with a value"]
    return ", ".join(parts)


def _span(counts: Sequence[int]) -> str:
    low, high = min(counts), max(counts)
    return f"{low}" if low == high else f"{low} to {high}"


def codes(groups: Sequence[EpisodeGroup]) -> tuple[str, ...]:
    """Return the hashes of the code that ran the episodes, sorted."""
    return tuple(sorted({group.code for group in groups}))
