"""Budgets of the benchmark: the least speed and the most memory that are accepted."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

MILLION = 1e6


@dataclass(frozen=True)
class Verdict:
    """One benchmark result beside its budget."""

    what: str
    measured: float
    budget: float
    unit: str
    is_met: bool


SPEEDS = {
    ("es1 x 30", "rigid"): 0.5,
    ("es1 x 30", "kinematic"): 1.5,
    ("es3", "rigid"): 1.0,
    ("es3", "kinematic"): 1.5,
}
"""Least robot-steps per second of a block under an engine [10^6 / s]."""

DICTIONARY_SPEEDS = {"rigid": 0.1, "kinematic": 0.12}
"""Least robot-steps per second of es1 through PettingZoo's dictionaries [10^6 / s]."""

COST_RATIO = 1.5
"""Most that a robot among 10,000 may cost, against one among 100 at the same density."""

START_UP = {"import": 1.0, "first_run": 60.0, "help": 2.0, "list": 2.0}
"""Most that each may take [s]."""

START_UP_NAMES = {
    "import": "import swarm_forage_env",
    "first_run": "first run, which compiles",
    "help": "swarm-forage --help",
    "list": "swarm-forage list",
}

GROWTH = 1.0
"""Most by which peak memory may grow in a long run [MB]: flat, but for the allocator."""


def check(found: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Every budget with its result, as dictionaries."""
    return [asdict(verdict) for verdict in verdicts(found)]


def verdicts(found: Mapping[str, Any]) -> list[Verdict]:
    """Every budget with its result."""
    speeds = {row["case"]: row for row in found["speeds"]}
    unit = "M/s"
    listed = [
        _at_least(f"{case}, {physics}", speeds[case][physics] / MILLION, budget, unit)
        for (case, physics), budget in SPEEDS.items()
    ]
    listed += [
        _at_least(
            f"PettingZoo, es1, {engine}", found["dictionaries"][engine] / MILLION, budget, unit
        )
        for engine, budget in DICTIONARY_SPEEDS.items()
    ]
    for engine in ("rigid", "kinematic"):
        ratio = speeds["es3 spread"][engine] / speeds["es3 x 100"][engine]
        name = f"cost of a robot, 10,000 : 100, {engine}"
        listed.append(_at_most(name, ratio, COST_RATIO, ""))
    listed += [
        _at_most(START_UP_NAMES[name], found["start_up_s"][name], budget, "s")
        for name, budget in START_UP.items()
        if name in found["start_up_s"]
    ]
    memory = found["memory"]
    name = f"memory growth, {memory['ticks']:,} ticks"
    return [*listed, _at_most(name, memory["growth_mb"], GROWTH, "MB")]


def _at_least(what: str, measured: float, budget: float, unit: str) -> Verdict:
    return Verdict(what, measured, budget, unit, measured >= budget)


def _at_most(what: str, measured: float, budget: float, unit: str) -> Verdict:
    return Verdict(what, measured, budget, unit, measured <= budget)
