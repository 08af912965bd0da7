"""Format evaluated episodes as a table with intervals, as JSON and as CSV."""

import csv
import io
import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, fields
from typing import Any

from rich.console import Group
from rich.table import Table
from rich.text import Text

from baselines.evaluation.episode import kind_of_episode
from baselines.evaluation.statistics import Comparison, Estimate, compare, mean_interval

NOT_APPLICABLE = "n/a"

EpisodesByController = Mapping[str, Sequence[Any]]
"""Episodes by controller, the seeds in the same order for each."""


def by_controller(episodes: Sequence[Any]) -> dict[str, list[Any]]:
    """Group episodes by controller, in the order of their first appearance."""
    groups: dict[str, list[Any]] = {}
    for episode in episodes:
        groups.setdefault(episode.controller, []).append(episode)
    return groups


def to_json(episodes: Sequence[Any], series: bool = False) -> str:
    """Episodes as one JSON array, one a line; the series over time only if asked for."""
    left_out = () if series else kind_of_episode(episodes[0]).series
    lines = (json.dumps(_without(left_out, episode), allow_nan=False) for episode in episodes)
    return "[\n" + ",\n".join(lines) + "\n]"


def to_csv(episodes: Sequence[Any]) -> str:
    """Episodes as CSV with a header, without series; missing values are empty."""
    text = io.StringIO()
    series = kind_of_episode(episodes[0]).series
    names = [each.name for each in fields(episodes[0]) if each.name not in series]
    writer = csv.DictWriter(text, names, lineterminator="\n")
    writer.writeheader()
    writer.writerows(_without(series, episode) for episode in episodes)
    return text.getvalue().rstrip("\n")


def _without(left_out: Sequence[str], episode: Any) -> dict[str, Any]:  # noqa: ANN401 of any task
    return {name: value for name, value in asdict(episode).items() if name not in left_out}


def report(episodes: Sequence[Any]) -> Group:
    """The table of means and, for several controllers, of comparisons with the first."""
    groups = by_controller(episodes)
    first = next(iter(groups.values()))
    head = first[0]
    parts: list[Text | Table] = [
        Text(
            f"{head.scenario}: {head.n_robots} robots, {head.duration_s:g} s, {head.physics}"
            f" physics, seeds {first[0].seed} to {first[-1].seed}",
            style="bold",
        ),
        summary(groups),
        Text(f"n = {len(first)}: mean over its 95 % bootstrap interval.", style="dim"),
    ]
    if len(groups) > 1:
        parts += [
            Text(
                f"\n{kind_of_episode(head).score_words} against {next(iter(groups))}", style="bold"
            ),
            comparison(groups),
            Text(
                "On the same seeds, with 95 % bootstrap intervals; p: Mann-Whitney U, two-sided.",
                style="dim",
            ),
        ]
    return Group(*parts)


def summary(groups: EpisodesByController) -> Table:
    """The table of mean metrics of every controller, over their 95 % bootstrap intervals."""
    table, columns = _table(), _columns([each for own in groups.values() for each in own])
    for heading, _ in columns.values():
        table.add_column(Text(heading), justify="right", no_wrap=True)
    for name, episodes in groups.items():
        cells = [_cell(episodes, metric, factor) for metric, (_, factor) in columns.items()]
        table.add_row(_lines(name), *cells)
    return table


def _columns(episodes: Sequence[Any]) -> dict[str, tuple[str, float]]:
    """The metrics with their headings and factors, without those that no episode has."""
    kind = kind_of_episode(episodes[0])
    return {
        metric: column
        for metric, column in kind.columns.items()
        if metric not in kind.sometimes
        or any(getattr(episode, metric) is not None for episode in episodes)
    }


def comparison(groups: EpisodesByController) -> Table:
    """The table of every controller's score against the first one's, seed by seed."""
    (_, base), *others = groups.items()
    table = _table()
    for heading in ("difference of means", "ratio of means", "p"):
        table.add_column(Text(heading), justify="right", no_wrap=True)
    for name, episodes in others:
        found = compare(scores(episodes), scores(base))
        table.add_row(Text(name), *_verdict(found))
    return table


def _lines(name: str) -> Text:
    """A controller's name, with its parameters on lines below."""
    return Text(name.replace(":", ":\n ").replace(",", ",\n "))


def scores(episodes: Sequence[Any]) -> list[float]:
    """The score of each episode: round trips, or goals per robot."""
    return [getattr(episode, kind_of_episode(episode).score) for episode in episodes]


def _verdict(found: Comparison) -> tuple[str, str, str]:
    p = NOT_APPLICABLE if found.p is None else p_value(found.p)
    return _in_line(found.difference), _in_line(found.ratio), p


def _cell(episodes: Sequence[Any], metric: str, factor: float) -> Text:
    """A table cell: mean over interval, and the number of episodes if not all count."""
    values = [getattr(episode, metric) for episode in episodes]
    found = mean_interval([factor * value for value in values if value is not None])
    if found is None:
        return Text(NOT_APPLICABLE)
    number = _formatter(found.value)
    interval = "-".join(map(number, found.interval)) if found.interval else NOT_APPLICABLE
    partly = f"\nn = {found.n}" if found.n < len(values) else ""
    return Text(number(found.value)).append(f"\n{interval}{partly}", style="dim")


def _in_line(found: Estimate | None) -> str:
    if found is None:
        return NOT_APPLICABLE
    number = _formatter(found.value)
    interval = " to ".join(map(number, found.interval)) if found.interval else NOT_APPLICABLE
    return f"{number(found.value)} ({interval})"


def _formatter(value: float) -> Callable[[float], str]:
    """A number format with the decimals that `value` needs for three digits; 0.01 gets two."""
    size = abs(value)
    whole = math.floor(math.log10(size)) + 1 if size else 3
    decimals = 2 if 0.01 <= size < 1.0 else max(0, 3 - whole)
    return lambda number: f"{number:.{decimals}f}"


def p_value(p: float) -> str:
    """Format a p value."""
    return "< 0.0001" if p < 1e-4 else f"{p:.2g}"


def _table() -> Table:
    table = Table(box=None, padding=(0, 1, 0, 0))
    table.add_column("controller", overflow="fold")
    return table
