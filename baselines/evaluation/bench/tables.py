"""Tables of the benchmark results for a terminal."""

from collections.abc import Mapping
from typing import Any

from rich.console import Group
from rich.table import Table
from rich.text import Text

from baselines.evaluation.bench.budgets import MILLION
from baselines.evaluation.bench.stages import SHARES


def report(found: Mapping[str, Any]) -> Group:
    """Tables of speeds, stages and budgets, one below the other."""
    machine = ", ".join(f"{name} {value}" for name, value in found["machine"].items())
    hurried = " (quick: less exact)" if found["quick"] else ""
    return Group(
        Text(f"Million robot-steps per second, one core{hurried}", style="bold"),
        _speeds(found), _note(
            "arrays, dicts: through the environment on arrays, or PettingZoo's dictionaries;"
            " es3 spread, x 10, x 100: robots start all over an arena of so many times the size."
        ),
        Text("\nShare of a tick [%]", style="bold"),
        _stages(found),
        Text("\nBudgets", style="bold"),
        _budgets(found),
        _note(f"Peak memory of this process {found['peak_memory_mb']:.0f} MB; {machine}."),
    )  # fmt: skip


def _speeds(found: Mapping[str, Any]) -> Table:
    table = _table("", "robots", "rigid", "kinematic", "bare pymunk", "rigid tick : bare")
    for row in found["speeds"]:
        engines = (row[name] / MILLION for name in ("rigid", "kinematic", "bare_pymunk"))
        table.add_row(
            row["case"],
            f"{row['rows']:,}",
            *(f"{speed:.3f}" for speed in engines),
            f"{row['rigid_over_bare']:.2f}",
        )
    return table


def _stages(found: Mapping[str, Any]) -> Table:
    table = _table("", "engine", *SHARES)
    for row in found["stages"]:
        shares = (f"{100.0 * row['shares'][stage]:.0f}" for stage in SHARES)
        table.add_row(row["case"], row["physics"], *shares)
    return table


def _budgets(found: Mapping[str, Any]) -> Table:
    table = _table("", "measured", "budget", "")
    for row in found["budgets"]:
        missed = abs(row["measured"] / row["budget"] - 1.0)
        verdict = Text("met", "green") if row["is_met"] else Text(f"missed by {missed:.0%}", "red")
        unit = f" {row['unit']}" if row["unit"] else ""
        table.add_row(
            row["what"], f"{row['measured']:.3g}{unit}", f"{row['budget']:g}{unit}", verdict
        )
    return table


def _table(first: str, *others: str) -> Table:
    table = Table(box=None, padding=(0, 1, 0, 0))
    table.add_column(first)
    for heading in others:
        table.add_column(heading, justify="right")
    return table


def _note(text: str) -> Text:
    return Text(text, style="dim")
