"""Episodes as a table with intervals that fits a terminal, as JSON, as CSV, and in Markdown."""

import csv
import io
import json
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, fields

from rich.cells import cell_len
from rich.console import Console, ConsoleOptions, Group
from rich.table import Table
from rich.text import Text

from baselines.evaluation.episode import AnyEpisode, kind_of_episode, present_values
from baselines.evaluation.statistics import Comparison, Estimate, compare, mean_interval


@dataclass(frozen=True)
class FittingTable:
    """Columns of numbers beside the names of controllers, in as many tables as the width takes."""

    head: str
    """Heading of the names."""
    names: Sequence[str]
    """What each row is of."""
    columns: Mapping[str, Sequence[Text]]
    """Cells of each column by its heading, a cell for each name."""

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> Iterator[Table | Text]:
        """The tables, one below the other, each with the names of the rows."""
        names = self._names(options.max_width)
        for number, headings in enumerate(self._parts(options.max_width - _width(names))):
            if number:
                yield Text()
            yield self._table(names, headings)

    def _names(self, width: int) -> list[Text]:
        """The heading and the names, in one line each if all columns fit beside them."""
        names = [Text(name) for name in (self.head, *self.names)]
        if _width(names) + sum(map(self._column_width, self.columns)) <= width:
            return names
        return [in_lines(name) for name in (self.head, *self.names)]

    def _parts(self, room: int) -> list[list[str]]:
        """The headings of the columns that stand side by side."""
        parts: list[list[str]] = []
        left = 0
        for heading in self.columns:
            left -= self._column_width(heading)
            if left < 0 or not parts:
                parts.append([])
                left = room - self._column_width(heading)
            parts[-1].append(heading)
        return parts

    def _column_width(self, heading: str) -> int:
        return _width([Text(heading), *self.columns[heading]])

    def _table(self, names: Sequence[Text], headings: Sequence[str]) -> Table:
        table = Table(box=None, padding=(0, 1, 0, 0))
        table.add_column(names[0], overflow="fold")
        for heading in headings:
            table.add_column(Text(heading), justify="right", no_wrap=True)
        for row, name in enumerate(names[1:]):
            table.add_row(name, *(self.columns[heading][row] for heading in headings))
        return table


def in_lines(name: str) -> Text:
    """A controller's name, with its layers or parameters on lines below."""
    for mark, broken in ((":", ":\n "), (",", ",\n "), ("+", "\n +")):
        name = name.replace(mark, broken)
    return Text(name)


def _width(texts: Sequence[Text]) -> int:
    """Width of a column, with the space beside it."""
    return 1 + max(cell_len(line) for text in texts for line in text.plain.split("\n"))


NOT_APPLICABLE = "n/a"

COMPARED = "difference of means", "ratio of means", "p"
"""Headings of the comparison."""

EpisodesByController = Mapping[str, Sequence[AnyEpisode]]
"""Episodes by controller, the seeds in the same order for each."""


def by_controller(episodes: Sequence[AnyEpisode]) -> dict[str, list[AnyEpisode]]:
    """Group episodes by controller, in the order of their first appearance."""
    groups: dict[str, list[AnyEpisode]] = {}
    for episode in episodes:
        groups.setdefault(episode.controller, []).append(episode)
    return groups


def to_json(episodes: Sequence[AnyEpisode], series: bool = False) -> str:
    """Episodes as one JSON array, one a line; with `series` also those over time."""
    left_out = () if series else kind_of_episode(episodes[0]).series
    lines = (json.dumps(_without(left_out, episode), allow_nan=False) for episode in episodes)
    return "[\n" + ",\n".join(lines) + "\n]"


def to_csv(episodes: Sequence[AnyEpisode]) -> str:
    """Episodes as CSV with a header, without series; missing values are empty."""
    text = io.StringIO()
    series = kind_of_episode(episodes[0]).series
    names = [each.name for each in fields(episodes[0]) if each.name not in series]
    writer = csv.DictWriter(text, names, lineterminator="\n")
    writer.writeheader()
    writer.writerows(_without(series, episode) for episode in episodes)
    return text.getvalue().rstrip("\n")


def _without(left_out: Sequence[str], episode: AnyEpisode) -> dict[str, object]:
    return {name: value for name, value in asdict(episode).items() if name not in left_out}


def report(episodes: Sequence[AnyEpisode]) -> Group:
    """The tables of means and, for several controllers, of comparisons with the first."""
    groups = by_controller(episodes)
    first = next(iter(groups.values()))
    head = first[0]
    kind = kind_of_episode(head)
    parts: list[Text | FittingTable] = [
        Text(
            f"{head.scenario}: {head.n_robots} robots, {head.duration_s:g} s, {head.physics}"
            f" physics, seeds {first[0].seed} to {first[-1].seed}",
            style="bold",
        ),
        summary(groups, [metric for metric in kind.columns if metric not in kind.sometimes]),
    ]
    sometimes = [metric for metric in kind.columns if metric in kind.sometimes]
    if added := [metric for metric in sometimes if present_values(episodes, metric)]:
        parts += [Text(f"\n{kind.sometimes_words}", style="bold"), summary(groups, added)]
    parts.append(
        Text(f"n = {len(first)}: the mean, and below it its 95 % bootstrap interval.", style="dim")
    )
    if len(groups) > 1:
        parts += [
            Text(f"\n{kind.score_words} against {next(iter(groups))}", style="bold"),
            comparison(groups),
            Text(
                "On the same seeds, with 95 % bootstrap intervals; p: Mann-Whitney U, two-sided.",
                style="dim",
            ),
        ]
    return Group(*parts)


def summary(groups: EpisodesByController, metrics: Sequence[str]) -> FittingTable:
    """The means of these metrics for every controller, over their 95 % bootstrap intervals."""
    (first, *_), *_ = groups.values()
    columns = {metric: kind_of_episode(first).columns[metric] for metric in metrics}
    return FittingTable(
        "controller",
        list(groups),
        {
            heading: [_cell(episodes, metric, factor) for episodes in groups.values()]
            for metric, (heading, factor) in columns.items()
        },
    )


def comparison(groups: EpisodesByController) -> FittingTable:
    """The table of every controller's score against the first one's, seed by seed."""
    (_, base), *others = groups.items()
    rows = [_verdict(compare(scores(episodes), scores(base))) for _, episodes in others]
    columns = {heading: [Text(row[k]) for row in rows] for k, heading in enumerate(COMPARED)}
    return FittingTable("controller", [name for name, _ in others], columns)


def scores(episodes: Sequence[AnyEpisode]) -> list[float]:
    """The score of each episode: round trips, or goals per robot."""
    return present_values(episodes, kind_of_episode(episodes[0]).score)


def _verdict(comparison: Comparison) -> tuple[str, str, str]:
    p = NOT_APPLICABLE if comparison.p is None else p_value(comparison.p)
    return _in_line(comparison.difference), _in_line(comparison.ratio), p


def _cell(episodes: Sequence[AnyEpisode], metric: str, factor: float) -> Text:
    """A table cell: mean over interval, and the number of episodes if not all count."""
    estimate = mean_interval(present_values(episodes, metric, factor))
    if estimate is None:
        return Text(NOT_APPLICABLE)
    number = _formatter(estimate.value)
    interval = "-".join(map(number, estimate.interval)) if estimate.interval else NOT_APPLICABLE
    partly = f"\nn = {estimate.n}" if estimate.n < len(episodes) else ""
    return Text(number(estimate.value)).append(f"\n{interval}{partly}", style="dim")


def _in_line(estimate: Estimate | None) -> str:
    if estimate is None:
        return NOT_APPLICABLE
    number = _formatter(estimate.value)
    interval = " to ".join(map(number, estimate.interval)) if estimate.interval else NOT_APPLICABLE
    return f"{number(estimate.value)} ({interval})"


def _formatter(value: float) -> Callable[[float], str]:
    """A number format with the decimals that `value` needs for three digits; 0.01 gets two."""
    size = abs(value)
    whole = math.floor(math.log10(size)) + 1 if size else 3
    decimals = 2 if 0.01 <= size < 1.0 else max(0, 3 - whole)
    return lambda number: f"{number:.{decimals}f}"


def markdown(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table in Markdown."""
    return "\n".join(f"| {' | '.join(row)} |" for row in (heads, ["---"] * len(heads), *rows))


def p_value(p: float) -> str:
    """Format a p value."""
    return "< 0.0001" if p < 1e-4 else f"{p:.2g}"
