"""Profile of a tick: the share of the time that each of its stages takes."""

import time
from collections import defaultdict
from collections.abc import Callable
from typing import Any

from baselines.evaluation.bench.cases import Case
from swarm_forage_env.loop import ControlLoop

TICKS, QUICK_TICKS = 600, 100

STAGES = (
    "physics",
    "contacts",
    "sensors",
    "radio",
    "estimate",
    "weigh",
    "motion",
    "rest",
)
"""contacts: finding neighbours and pushing them apart; estimate: what the estimator
takes in and says; weigh: the rule and the merge; rest: scoring and Python between the stages."""


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
    spent["rest"] = max(0.0, whole - sum(spent.values()))
    return {stage: spent[stage] / whole for stage in STAGES}


def _put_clocks(loop: ControlLoop, spent: defaultdict[str, float]) -> None:
    """Replace each stage of this loop by one that measures its time."""
    world, controller = loop.world, loop.controller
    for owner, name, stage in (
        (world._physics, "move", "physics"),
        (world, "_settle", "contacts"),
        (world, "_sense", "sensors"),
        (world, "_radio", "radio"),
        (controller.estimator, "observe", "estimate"),
        (controller.estimator, "say", "estimate"),
        (controller.estimator, "merge", "weigh"),
        (controller, "weighting", "weigh"),
        (controller, "motion", "motion"),
    ):
        setattr(owner, name, Clocked(getattr(owner, name), stage, spent))


class Clocked:
    """A callable that adds up the time of every call of a stage."""

    def __init__(
        self, inner: Callable[..., Any], stage: str, spent: defaultdict[str, float]
    ) -> None:
        """Wrap the callable `inner`."""
        self._inner, self._stage, self._spent = inner, stage, spent

    def __call__(self, *arguments: Any) -> Any:  # noqa: ANN401 whatever the stage takes
        """Call the stage and add the time it took."""
        start = time.perf_counter()
        result = self._inner(*arguments)
        self._spent[self._stage] += time.perf_counter() - start
        return result

    def __getattr__(self, name: str) -> Any:  # noqa: ANN401 whatever the stage has
        """Pass every other attribute on to the wrapped stage."""
        return getattr(self._inner, name)
