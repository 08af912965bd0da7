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
    "es1 x 30": {"kinematic": 4.0, "rigid": 1.2},
    "es3": {"kinematic": 3.0, "rigid": 1.0},
    "es1, ten ticks a call": {"kinematic": 2.5, "rigid": 0.4},
    "es1 x 64, arrays": {"kinematic": 4.0, "rigid": 1.0},
    "es1, dicts": {"kinematic": 0.2, "rigid": 0.15},
}
"""Least robot-steps per second of a case under each engine [10^6 / s]: of blocks of worlds, of the
environment on arrays, and of PettingZoo's dictionaries."""

GAIN_PER_THREAD = 0.9
"""Least gain in speed that each thread brings: 1.8 of two."""

COST_RATIO = 1.5
"""Most that a robot among 10,000 may cost, against one among 100 at the same density."""

START_UP = {"import": 0.3, "first_run": 30.0, "help": 1.0, "list": 1.0}
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
    listed = [
        _at_least(f"{case}, {engine}", speeds[case][engine] / MILLION, budget, "M/s")
        for case, budgets in SPEEDS.items()
        for engine, budget in budgets.items()
    ]
    for row in found["threads"]:
        name = f"{row['threads']} threads : 1, {row['physics']}"
        listed.append(_at_least(name, row["gain"], GAIN_PER_THREAD * row["threads"], ""))
    for engine in ("kinematic", "rigid"):
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
