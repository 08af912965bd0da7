"""Tables of calibration results for a terminal, and the same as data for JSON."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

from rich.table import Table
from rich.text import Text

from baselines.evaluation.statistics import Comparison, Estimate
from calibration.boids_gains import GAINS, StaticGains
from calibration.ranges import ARENAS, RANGES, Values, defaults
from calibration.runner import SensitivityResult
from calibration.targets import Target, score, term

MAIN = tuple((arena, controller) for arena in ARENAS for controller in ("nc", "ssgikf"))
"""Arenas and controllers whose round trips the table of the sensitivity shows."""

Estimates = Mapping[Target, Estimate | None]


def rows(estimates: Estimates) -> list[dict[str, Any]]:
    """Every target with its published and measured number, as data."""
    found = []
    for target, ours in estimates.items():
        low, high = ours.interval if ours and ours.interval else (None, None)
        value = ours.value if ours else None
        cost = None if value is None else term(target, value)
        measured = {"ours": value, "low": low, "high": high, "cost": cost}
        found.append({"name": target.name, **asdict(target), **measured})
    return found


def fit_table(measured: Mapping[Target, float]) -> Table:
    """Table of the targets with published and measured numbers, and their terms of the score."""
    table = _table("arena", "quantity", ">published", ">ours", ">weight", ">cost", "source")
    for target, ours in measured.items():
        table.add_row(
            target.arena, target.name, target.bound, _number(ours), f"{target.weight:g}",
            f"{term(target, ours):.3f}", target.source,
        )  # fmt: skip
    table.add_row("", "score", "", "", "", f"{score(measured):.3f}", "", style="bold")
    return table


def report_table(estimates: Estimates) -> Table:
    """Table of the targets with published and measured numbers, and their intervals."""
    table = _table("arena", "quantity", ">published", ">ours", ">95 % interval", ">n", "source")
    for target, ours in estimates.items():
        cells = ("n/a", "", "") if ours is None else (_number(ours.value), _span(ours), str(ours.n))
        table.add_row(target.arena, target.name, target.bound, *cells, target.source)
    return table


def values_table(values: Values) -> Table:
    """Table of every parameter: value, present default, range, and the reason for the range."""
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


def gains_table(found: Sequence[StaticGains], worths: Sequence[Comparison]) -> Table:
    """Table of the best static gains of the boids, their cost, and its ratio to unit gains."""
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
    base: Mapping[Target, float], varied: Sequence[SensitivityResult], values: Values
) -> Table:
    """Table of the sensitivity: each parameter varied alone, its score and round trips."""
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
    base: Mapping[Target, float], varied: Sequence[SensitivityResult]
) -> list[dict[str, Any]]:
    """The sensitivity as data, with every target as measured."""
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
    return [f"{trips[key]:.0f}" for key in MAIN]


def _leaf(name: str) -> str:
    return name.rpartition(".")[2]


def _number(value: float) -> str:
    """Format a number with three digits, or all before the point: 0.0647, 1226."""
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
