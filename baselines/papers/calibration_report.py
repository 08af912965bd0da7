"""What a calibration found, as tables and as data."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

from rich.table import Table
from rich.text import Text

from baselines.evaluation.statistics import Comparison, Estimate
from baselines.papers.calibration_boids import GAINS, Gains
from baselines.papers.calibration_ranges import ARENAS, RANGES, Values, defaults
from baselines.papers.calibration_swarm import Varied
from baselines.papers.calibration_targets import Target, score, term

MAIN = tuple((arena, controller) for arena in ARENAS for controller in ("nc", "ssgikf"))
"""Arenas and controllers whose round trips the table of the sensitivity shows."""

Estimates = Mapping[Target, Estimate | None]


def rows(estimates: Estimates) -> list[dict[str, Any]]:
    """Each target with what was measured, as data."""
    found = []
    for target, ours in estimates.items():
        low, high = ours.interval if ours and ours.interval else (None, None)
        value = ours.value if ours else None
        cost = None if value is None else term(target, value)
        measured = {"ours": value, "low": low, "high": high, "cost": cost}
        found.append({"name": target.name, **asdict(target), **measured})
    return found


def fit_table(measured: Mapping[Target, float]) -> Table:
    """Quantity, published, ours, and what it adds to the score."""
    table = _table("arena", "quantity", ">published", ">ours", ">weight", ">cost", "source")
    for target, ours in measured.items():
        table.add_row(
            target.arena, target.name, target.bound, _number(ours), f"{target.weight:g}",
            f"{term(target, ours):.3f}", target.source,
        )  # fmt: skip
    table.add_row("", "score", "", "", "", f"{score(measured):.3f}", "", style="bold")
    return table


def report_table(estimates: Estimates) -> Table:
    """Quantity, published, and ours with its interval."""
    table = _table("arena", "quantity", ">published", ">ours", ">95 % interval", ">n", "source")
    for target, ours in estimates.items():
        cells = ("n/a", "", "") if ours is None else (_number(ours.value), _span(ours), str(ours.n))
        table.add_row(target.arena, target.name, target.bound, *cells, target.source)
    return table


def values_table(values: Values) -> Table:
    """Every parameter: its value, its default today, its range and the reason for that."""
    table = _table("parameter", ">value", ">default", ">from", ">to", "why this range")
    before = defaults()
    for each in RANGES:
        numbers = values[each.name], before[each.name], each.low, each.high
        table.add_row(each.name, *(f"{number:g}" for number in numbers), Text(each.reason))
    return table


SHORT = {
    "dead_reckoning": "DR",
    "covariance_intersection": "CI",
    "decentralised_ekf": "DEKF",
}
"""Filters by the names of BOIDS, for a narrow table."""


def gains_table(found: Sequence[Gains], worths: Sequence[Comparison]) -> Table:
    """The best static gains of the boids; their cost, and its ratio to that of gains of one."""
    heads = (">align", ">separate", ">cohere", ">home")
    table = _table("filter", ">robots", *heads, ">cost", ">to ones", ">p")
    for each, worth in zip(found, worths, strict=True):
        ratio = f"{worth.ratio.value:.2f}" if worth.ratio else "n/a"
        p = "n/a" if worth.p is None else f"{worth.p:.2g}"
        gains = (f"{each.gains[name]:.2f}" for name in GAINS)
        table.add_row(
            SHORT[each.estimator], str(each.n_robots), *gains, f"{each.cost:.3f}", ratio, p
        )
    return table


def sensitivity_table(
    base: Mapping[Target, float], varied: Sequence[Varied], values: Values
) -> Table:
    """Each parameter varied alone: the change of the score, and the round trips."""
    table = _table("parameter", ">was", ">score", *(f">{arena}\n{name}" for arena, name in MAIN))
    table.padding = (0, 1, 0, 0)
    table.add_row("(the set)", "", f"{score(base):.2f}", *_main(base), style="bold")
    for each in varied:
        change = f"{score(each.measured) - score(base):+.2f}"
        name = each.parameter if each.parameter.startswith(ARENAS) else _leaf(each.parameter)
        row = f"{name} = {each.value:.4g}", f"{values[each.parameter]:.4g}"
        table.add_row(*row, change, *_main(each.measured))
    return table


def sensitivity_rows(
    base: Mapping[Target, float], varied: Sequence[Varied]
) -> list[dict[str, Any]]:
    """The same as data, with every target as measured."""
    return [
        {
            "parameter": each.parameter,
            "value": each.value,
            "score": score(each.measured),
            "change": score(each.measured) - score(base),
            "measured": {
                f"{target.arena}: {target.name} {target.bound}": x if math.isfinite(x) else None
                for target, x in each.measured.items()
            },
        }
        for each in varied
    ]


def _main(measured: Mapping[Target, float]) -> list[str]:
    trips = {
        (target.arena, *target.controllers): ours
        for target, ours in measured.items()
        if target.quantity == "round_trips" and not target.over
    }
    return [f"{trips[cell]:.0f}" for cell in MAIN]


def _leaf(name: str) -> str:
    return name.rpartition(".")[2]


def _number(value: float) -> str:
    """With three digits, or all before the point: 0.0647, 1226."""
    return f"{value:.0f}" if abs(value) >= 1000.0 else f"{value:.3g}"


def _span(found: Estimate) -> str:
    return "n/a" if found.interval is None else " to ".join(map(_number, found.interval))


def _table(*headings: str) -> Table:
    """A table; columns whose headings start with `>` hold numbers."""
    table = Table(box=None, padding=(0, 2, 0, 0))
    for heading in headings:
        number = heading.startswith(">")
        table.add_column(
            Text(heading.removeprefix(">")),
            justify="right" if number else "left",
            overflow="fold",
            no_wrap=number,
        )
    return table
