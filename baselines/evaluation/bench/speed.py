"""Speed in robot-steps per second: of whole ticks, of bare pymunk, and on several threads."""

import statistics
import time
from typing import Any

from baselines.evaluation.bench.bare import bare_pymunk
from baselines.evaluation.bench.cases import Case, Tick

REPEATS, LENGTH = 5, 0.5
"""How often a measure is repeated, and about how long each takes [s]; the median counts."""

QUICK_REPEATS, QUICK_LENGTH = 3, 0.15


def seconds_per_tick(tick: Tick, quick: bool) -> float:
    """Median time of one tick [s], over repeats of as many ticks as fill a fixed time."""
    repeats, length = (QUICK_REPEATS, QUICK_LENGTH) if quick else (REPEATS, LENGTH)
    tick()
    count = max(3, round(length / max(_timed(tick, 3), 1e-7)))
    return statistics.median(_timed(tick, count) for _ in range(repeats))


def case_speeds(case: Case, quick: bool) -> dict[str, Any]:
    """Robot-steps per second of a block under both engines, and of bare pymunk."""
    rigid = seconds_per_tick(case.tick("rigid", quick), quick)
    kinematic = seconds_per_tick(case.tick("kinematic", quick), quick)
    bare = seconds_per_tick(bare_pymunk(case), quick)
    return {
        "case": case.name,
        "rows": case.rows,
        "rigid": case.robot_steps / rigid,
        "kinematic": case.robot_steps / kinematic,
        "bare_pymunk": case.rows / bare,
        "rigid_over_bare": rigid / case.n_ticks / bare,
    }


def thread_gain(case: Case, physics: str, threads: int, quick: bool) -> float:
    """How much faster a block is on several threads than on one."""
    one, several = (
        seconds_per_tick(case.tick(physics, quick, each), quick) for each in (1, threads)
    )
    return one / several


def _timed(tick: Tick, count: int) -> float:
    """Mean time of so many ticks [s]."""
    start = time.perf_counter()
    for _ in range(count):
        tick()
    return (time.perf_counter() - start) / count
