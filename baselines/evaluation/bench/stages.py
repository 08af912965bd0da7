"""Profile of a tick: the share of the time that each of its stages takes."""

import time

from baselines.evaluation.bench.cases import Case
from swarm_forage_env.compiler import bind
from swarm_forage_env.ticks import STAGES, only, run_ticks

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
