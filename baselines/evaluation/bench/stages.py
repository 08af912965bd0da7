"""Profile of a tick: the share of the time that each of its stages takes."""

import time
from collections import defaultdict
from collections.abc import Callable
from typing import Any

from baselines.evaluation.bench.cases import Case
from swarm_forage_env.loop import Loop

TICKS, QUICK_TICKS = 600, 100

STAGES = ("decide", "engine", "tick", "observe", "rest")
"""engine: what moves bodies that may touch, before the kernel `tick`, which moves all others,
scores, senses and lets hear; rest: Python between the stages."""


def stage_shares(case: Case, physics: str, quick: bool) -> dict[str, float]:
    """Share of a tick's time that each stage takes; the timers' own cost counts as rest."""
    loop = case.start(physics, quick)
    spent: defaultdict[str, float] = defaultdict(float)
    _put_clocks(loop, spent)
    loop.step()
    spent.clear()
    ticks = max(10, (QUICK_TICKS if quick else TICKS) * 100 // max(100, case.rows))
    start = time.perf_counter()
    for _ in range(ticks):
        loop.step()
    whole = time.perf_counter() - start
    spent["tick"] -= spent["engine"]  # which is called from there
    spent["rest"] = max(0.0, whole - sum(spent.values()))
    return {stage: spent[stage] / whole for stage in STAGES}


def _put_clocks(loop: Loop, spent: defaultdict[str, float]) -> None:
    """Replace each stage of this loop by one that measures its time."""
    world, controller = loop.world, loop.controller
    for owner, name, stage in (
        (controller, "decide", "decide"),
        (world._physics, "move", "engine"),  # type: ignore[attr-defined]
        (world, "tick", "tick"),
        (controller, "observe", "observe"),
    ):
        setattr(owner, name, timed(getattr(owner, name), stage, spent))


def timed(
    inner: Callable[..., Any], stage: str, spent: defaultdict[str, float]
) -> Callable[..., Any]:
    """The same function, which adds the time of every call to that of its stage."""

    def call(*arguments: Any) -> Any:  # noqa: ANN401 whatever the stage takes
        start = time.perf_counter()
        result = inner(*arguments)
        spent[stage] += time.perf_counter() - start
        return result

    return call
