"""The goals of worlds on a GPU, and the tables of what was measured there for a terminal."""

from rich.console import Group, RenderableType
from rich.text import Text

from baselines.evaluation.bench.cases import Measured
from baselines.evaluation.bench.tables import MILLION, budgets_table, verdicts
from baselines.evaluation.tables import FittingTable

SPEEDS = {
    "gpu": ("GPU", {"es1 x 100": 60.0, "es1 x 1000": 250.0, "es1 x 10000": 350.0}),
    "environment": ("learning", {"es1 x 1000": 150.0, "es1 x 10000": 200.0}),
}
"""Least robot-steps per second on an H200 [10^6 / s], by the column of the table."""

SECONDS = {
    "first_step_s": ("first step of a second start", {"es1 x 1": 3.0}),
    "made_s": ("made and reset", {"es1 x 100000": 2.0}),
}
"""Most that it may take there [s]."""

STAGES = "decide", "tick", "observe"


def gpu_table(measured: list[Measured]) -> Group:
    """Table with a row for each number of worlds; a dash for what the driver does not report."""
    rows = [_cells(each) for each in measured]
    columns = {heading: [Text(row[heading]) for row in rows] for heading in rows[0]}
    parts: list[RenderableType] = [
        Text("Worlds on a GPU: kinematic, ssgikf; millions of robot-steps a second", style="bold"),
        FittingTable("worlds", [each["case"] for each in measured], columns),
        Text(
            "Bytes are those of the records that the kernels are handed, each read or written"
            " once. Energy is in joules per million robot-steps. Learning: by the arrays of an"
            " environment whose motion is learned, without a network. VMAS: its navigation with 8"
            " rays and collisions, 10 agents, where it is installed.",
            style="dim",
        ),
    ]
    if goals := goals_of(measured):
        parts += [Text("\nGoals, of an H200", style="bold"), budgets_table(goals)]
    return Group(*parts)


def goals_of(measured: list[Measured]) -> list[Measured]:
    """Every goal of a number of worlds that was measured, with its result."""
    by_case = {each["case"]: each for each in measured}
    least, most = (
        [
            (f"{case}: {words}", by_case[case][key] / unit, goal, name)
            for key, (words, goals) in each.items()
            for case, goal in goals.items()
            if case in by_case
        ]
        for each, unit, name in ((SPEEDS, MILLION, "M/s"), (SECONDS, 1.0, "s"))
    )
    return verdicts(least, most)


def _cells(each: Measured) -> dict[str, str]:
    return {
        "GPU": _millions(each["gpu"]),
        "learning": _millions(each["environment"]),
        "VMAS": _or_dash(each["vmas"], ".3g", 1e-6),
        "CPU": _millions(each["cpu"]),
        "threads": str(each["threads"]),
        **{stage: _or_dash(each["shares"].get(stage), ".0%") for stage in STAGES},
        "bytes": f"{each['bytes_per_robot_step']:.0f}",
        "GB/s": _or_dash(each["bandwidth"], ".0f", 1e-9),
        "of card": _or_dash(each["share_of_card"], ".0%"),
        "J": _or_dash(each["joules_per_million"], ".3g"),
        "first [s]": f"{each['first_step_s']:.1f}",
    }


def _millions(speed: float) -> str:
    millions = speed / 1e6
    return f"{millions:,.0f}" if millions >= 100.0 else f"{millions:.3g}"


def _or_dash(number: float | None, form: str, scale: float = 1.0) -> str:
    return "-" if number is None else format(number * scale, form)
