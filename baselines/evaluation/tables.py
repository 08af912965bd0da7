"""Episodes as tables with intervals for a terminal, as JSON and as CSV; tables in Markdown."""

import csv
import io
import json
import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass

import numpy as np
from rich.cells import cell_len
from rich.console import Console, ConsoleOptions, Group
from rich.table import Column, Table
from rich.text import Text

from baselines.evaluation.console import count_noun
from baselines.evaluation.episode import AnyEpisode, kind_of_episode, present_values
from baselines.evaluation.experiment_config import ExperimentConfig, shortened
from baselines.evaluation.statistics import Estimate, compare, mean_interval
from swarm_forage_env.arrays import Array
from swarm_forage_env.foraging.episode import ForagingEpisode


@dataclass(frozen=True)
class FittingTable:
    """Table of named rows, split by columns into several tables if the terminal is narrower."""

    head: str  # heading of the names
    names: Sequence[str]  # name of each row
    columns: Mapping[str, Sequence[Text]]
    """Cells of each column by its heading, a cell for each name."""

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> Iterator[Table | Text]:
        """Yield the tables, one below the other, each with the names of the rows."""
        widths = {heading: _width([Text(heading), *col]) for heading, col in self.columns.items()}
        names = [Text(name) for name in (self.head, *self.names)]
        if _width(names) + sum(widths.values()) > options.max_width:
            lines = (re.sub("([:,])", "\\1\n ", name.plain) for name in names)
            names = [Text(name.replace("+", "\n +")) for name in lines]
        available = left = options.max_width - _width(names)
        parts: list[list[str]] = [[]]
        for heading, width in widths.items():
            if width > left and parts[-1]:
                parts.append([])
                left = available
            parts[-1].append(heading)
            left -= width
        for number, headings in enumerate(parts):
            if number:
                yield Text()
            yield self._table(names, headings)

    def _table(self, names: Sequence[Text], headings: Sequence[str]) -> Table:
        table = Table(box=None, padding=(0, 1, 0, 0))
        table.add_column(names[0], overflow="fold")
        for heading in headings:
            table.add_column(Text(heading), justify="right", no_wrap=True)
        for row, name in enumerate(names[1:]):
            table.add_row(name, *(self.columns[heading][row] for heading in headings))
        return table


def _width(texts: Sequence[Text]) -> int:
    return 1 + max(cell_len(line) for text in texts for line in text.plain.split("\n"))


NOT_APPLICABLE = "n/a"

EpisodesByController = Mapping[str, Sequence[AnyEpisode]]
"""Episodes by controller, with the seeds in the same order for each."""


def to_json(
    episodes: Sequence[AnyEpisode], series: bool = False, changes: Sequence[str] = ()
) -> str:
    """Return episodes as one JSON array, one per line, with the changes of the scenario.

    `series` adds their time series.
    """
    left_out = () if series else kind_of_episode(episodes[0]).series
    rows = (_without(left_out, changes, episode) for episode in episodes)
    return "[\n{}\n]".format(",\n".join(json.dumps(row, allow_nan=False) for row in rows))


def to_csv(episodes: Sequence[AnyEpisode], changes: Sequence[str] = ()) -> str:
    """Return episodes as CSV with a header, without series; missing values are empty."""
    text, series = io.StringIO(), kind_of_episode(episodes[0]).series
    rows = [_without(series, changes, episode) for episode in episodes]
    writer = csv.DictWriter(text, [*rows[0]], lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue().rstrip("\n")


def _without(
    left_out: Sequence[str], changes: Sequence[str], episode: AnyEpisode
) -> dict[str, object]:
    numbers = {name: value for name, value in asdict(episode).items() if name not in left_out}
    return {"scenario": episode.scenario, "overrides": " ".join(changes)} | numbers


def report(episodes: Sequence[AnyEpisode], changes: Sequence[str] = ()) -> Group:
    """Return the tables of means and, for several controllers, of comparisons with the first.

    `changes` are those of the scenario, such as `radio.frames=1`.
    """
    groups: dict[str, list[AnyEpisode]] = {}
    for episode in episodes:
        groups.setdefault(episode.controller, []).append(episode)
    first = next(iter(groups.values()))
    head, kind = first[0], kind_of_episode(first[0])
    setup = ", ".join((head.scenario, *map(shortened, changes)))
    title = (
        f"{setup}: {count_noun(head.n_robots, 'robot')},"
        f" {head.duration_s:g} s, {head.physics} physics, seeds {head.seed} to {first[-1].seed}"
    )
    always = [metric for metric in kind.columns if metric not in kind.sometimes]
    present = [m for m in kind.columns if m in kind.sometimes and present_values(episodes, m)]
    parts: list[Text | FittingTable] = [Text(title, style="bold"), summary(groups, always)]
    if present:
        parts += [Text(f"\n{kind.sometimes_words}", style="bold"), summary(groups, present)]
    note = f"n = {len(first)}: the mean, and below it its 95 % interval, from two values on."
    counts = [len(present_values(each, m)) for each in groups.values() for m in always]
    if any(0 < count < len(first) for count in counts):
        note += "\nn = k of n: the others have no value, as where recruitment did not end."
    parts.append(Text(note, style="dim"))
    if len(groups) > 1:
        heading = f"\n{kind.score_words} against {head.controller}"
        words = "On the same seeds, with 95 % intervals; p: Mann-Whitney U, two-sided."
        parts += [Text(heading, style="bold"), comparison(groups), Text(words, style="dim")]
    return Group(*parts)


def summary(groups: EpisodesByController, metrics: Sequence[str]) -> FittingTable:
    """Return a table of the means of these metrics for every controller, with 95 % intervals."""
    (first, *_), *_ = groups.values()
    headings = kind_of_episode(first).columns
    columns = {
        headings[metric][0]: [_cell(each, metric, headings[metric][1]) for each in groups.values()]
        for metric in metrics
    }
    return FittingTable("controller", list(groups), columns)


def comparison(groups: EpisodesByController) -> FittingTable:
    """Return a table that compares the score of every controller with the first, seed by seed."""
    (_, base), *others = groups.items()
    compared = [compare(scores(episodes), scores(base)) for _, episodes in others]
    columns = {
        "difference of means": [_in_line(each.difference) for each in compared],
        "ratio of means": [_in_line(each.ratio) for each in compared],
        "p": [Text(NOT_APPLICABLE if each.p is None else p_value(each.p)) for each in compared],
    }
    return FittingTable("controller", [name for name, _ in others], columns)


def scores(episodes: Sequence[AnyEpisode]) -> list[float]:
    """Return the score of each episode: round trips, or goals per robot."""
    return present_values(episodes, kind_of_episode(episodes[0]).score)


WIDE, SHARE = 40.0, 0.2
"""Standard deviation of round trips, and its share of their mean; above both, episodes vary widely.
Hand-written controllers have 4 to 12 in es1, with means of 60 to 250."""

FAR = 0.8  # share of the score with noise below which a score without noise is far lower


def noise_lines(
    configurations: Sequence[ExperimentConfig], episodes: Sequence[Sequence[AnyEpisode]]
) -> Iterator[str]:
    """Yield a line for each policy that acts without noise but searches by it; foraging only.

    A policy that has learned to find areas by its noise drives in circles without it, in some
    episodes or in all. Its scores then differ widely, or are far below those with noise.
    """
    if not isinstance(episodes[0][0], ForagingEpisode):
        return
    policies = [
        (each.label, each.controller.parameters, np.array(scores(own)))
        for each, own in zip(configurations, episodes, strict=True)
    ]
    for label, parameters, trips in policies:
        noisy = parameters | {"policy.chance": True}
        with_noise = max((each.mean() for _, own, each in policies if own == noisy), default=0.0)
        if parameters.get("policy.chance") is False and (reason := _reason(trips, with_noise)):
            yield (
                f"policy {label} searches by its noise: {reason}; compare it with"
                f" {label},chance=true"
            )


def _reason(trips: Array, with_noise: float) -> str:
    """Return why a policy without noise seems to search by it; empty if it does not."""
    spread = trips.std(ddof=1) if len(trips) > 1 else 0.0
    if spread > max(WIDE, SHARE * trips.mean()):
        return f"its episodes differ by {spread:.0f} round trips (standard deviation)"
    if trips.mean() < FAR * with_noise:
        return f"it makes {trips.mean():.0f} round trips without, and {with_noise:.0f} with it"
    return ""


def _cell(episodes: Sequence[AnyEpisode], metric: str, factor: float) -> Text:
    """Return a cell: mean above interval, and the number of episodes if some have no value."""
    estimate = mean_interval(present_values(episodes, metric, factor))
    if estimate is None:
        return Text(NOT_APPLICABLE)
    is_below_zero = estimate.interval is not None and estimate.interval[0] < 0.0
    value, interval = _formatted(estimate, " to " if is_below_zero else "-")
    partly = f"\nn = {estimate.n} of {len(episodes)}" if estimate.n < len(episodes) else ""
    return Text(value).append(f"\n{interval}{partly}", style="dim")


def _in_line(estimate: Estimate | None) -> Text:
    return Text("{} ({})".format(*_formatted(estimate, " to ")) if estimate else NOT_APPLICABLE)


def _formatted(estimate: Estimate, between: str) -> tuple[str, str]:
    """A value with three digits, or 0.01 with two, and its interval with as many decimals."""
    size = max(abs(estimate.value), *(0.1 * abs(end) for end in estimate.ends))  # 0.00, not 0
    n_digits = math.floor(math.log10(size)) + 1 if size else 3
    decimals = 2 if 0.01 <= size < 1.0 else max(0, 3 - n_digits)
    value, *ends = (f"{x:z.{decimals}f}" for x in (estimate.value, *(estimate.interval or ())))
    return value, between.join(ends) or NOT_APPLICABLE


def plain_table(heads: Sequence[str], rows: Iterable[Sequence[str | Text]]) -> Table:
    """Return a table for a terminal; long cells are broken into lines."""
    columns = (Column(Text(head), overflow="fold") for head in heads)
    table = Table(*columns, box=None, padding=(0, 1, 0, 0))
    for row in rows:
        table.add_row(*(Text(cell) if isinstance(cell, str) else cell for cell in row))
    return table


def markdown(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table in Markdown."""
    return "\n".join(f"| {' | '.join(row)} |" for row in (heads, ["---"] * len(heads), *rows))


def p_value(p: float) -> str:
    """Format a p value."""
    return "< 0.0001" if p < 1e-4 else f"{p:.2g}"
