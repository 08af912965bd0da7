"""Speed in robot-steps per second, of ticks, of bare pymunk, on threads; shares of the stages."""

import statistics
import time
from typing import Any

from baselines.evaluation.bench.bare import bare_pymunk
from baselines.evaluation.bench.cases import Case, Tick
from swarm_forage_env.compiler import bind
from swarm_forage_env.ticks import STAGES, only, run_ticks

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


TICKS, QUICK_TICKS = 600, 100

SHARES = (*STAGES, "rest")
"""engine: what moves bodies that may touch, before the tick, which moves all others, scores, senses
and lets hear; rest: Python around the stages."""


def stage_shares(case: Case, physics: str, quick: bool) -> dict[str, float]:
    """Share of a tick's time that each stage takes, where each is a call of its own."""
    loop = case.start(physics, quick)
    world, layers = loop.world, loop.controller.compiled
    assert layers is not None  # the controller of all cases is compiled
    functions = {**world.functions, **layers.functions}
    kernels = {name: bind(run_ticks, {**functions, **only(name)}) for name in STAGES}
    spent = dict.fromkeys(STAGES, 0.0)
    arguments = world.arrays, layers.arrays, world.modes, world.trouble, 0, world.n_worlds, 1
    for run in kernels.values():  # compiles it
        run(*arguments)
    ticks = max(10, (QUICK_TICKS if quick else TICKS) * 100 // max(100, case.rows))
    begin = time.perf_counter()
    for _ in range(ticks):
        for name, run in kernels.items():
            start = time.perf_counter()
            run(*arguments)
            spent[name] += time.perf_counter() - start
    whole = time.perf_counter() - begin
    shares = {name: seconds / whole for name, seconds in spent.items()}
    return shares | {"rest": max(0.0, 1.0 - sum(shares.values()))}
