"""All benchmark measurements, as one dictionary that JSON can hold."""

import os
import platform
from collections.abc import Callable
from importlib.metadata import version
from typing import Any

from baselines.evaluation.bench import processes
from baselines.evaluation.bench.cases import all_cases
from baselines.evaluation.bench.speed import case_speeds, stage_shares, thread_gain
from baselines.evaluation.bench.tables import check

ENGINES = ("rigid", "kinematic")
STAGED = ("es1 x 30", "es3", "es3 x 100")
"""Cases whose stages are timed."""

THREADED = "es1 x 64"
"""The case that is run on several threads."""

MEMORY_TICKS, QUICK_MEMORY_TICKS = 1_000_000, 5_000

Tell = Callable[[str], None]


def measure(quick: bool, threads: int, tell: Tell) -> dict[str, Any]:
    """Run every benchmark; `tell` receives the name of each before it starts."""
    found: dict[str, Any] = {"quick": quick, "machine": _machine()}
    found |= _processes(quick, tell)
    found["speeds"], found["stages"], found["threads"] = [], [], []
    for case in all_cases():
        tell(f"speed of {case.name}")
        found["speeds"].append(case_speeds(case, quick))
        for physics in ENGINES if case.name in STAGED else ():
            tell(f"stages of {case.name}, {physics}")
            shares = stage_shares(case, physics, quick)
            found["stages"].append({"case": case.name, "physics": physics, "shares": shares})
        for physics in ENGINES if case.name == THREADED else ():
            tell(f"{threads} threads, {physics}")
            gain = thread_gain(case, physics, threads, quick)
            found["threads"].append({"physics": physics, "threads": threads, "gain": gain})
    found["peak_memory_mb"] = processes.peak_memory()
    found["budgets"] = check(found)
    return found


def _processes(quick: bool, tell: Tell) -> dict[str, Any]:
    """Start-up, first run and memory: each in new processes."""
    tell("start-up")
    start_up = processes.start_up(quick)
    if not quick:
        tell("the first run, which compiles")
        start_up["first_run"] = processes.first_run()
    ticks = QUICK_MEMORY_TICKS if quick else MEMORY_TICKS
    tell(f"memory over {ticks:,} ticks")
    peak, growth = processes.memory_growth(ticks)
    return {
        "start_up_s": start_up,
        "memory": {"ticks": ticks, "peak_mb": peak, "growth_mb": growth},
    }


def _machine() -> dict[str, Any]:
    """What the numbers were measured on."""
    libraries = {library: version(library) for library in ("numba", "numpy", "pymunk")}
    return {"python": platform.python_version(), "cores": os.cpu_count()} | libraries
