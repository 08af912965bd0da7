"""How long a plan will take, told before it starts: from a short run of each scenario."""

import time
from collections.abc import Sequence

from baselines.evaluation.configuration import Configuration
from baselines.evaluation.runner import MAX_ROWS, Plan, warm_up
from swarm_forage_env.loop import ControlLoop, WaypointsLoop, start_loop

PROBE = 0.3
"""Computing time of a probe, and as much again to let the robots meet [s]."""

BEAT = 20
"""Ticks between two looks at the clock."""


def expected_seconds(plan: Plan, workers: int) -> float:
    """Time for what a plan has still to run, from the speed of each scenario [s].

    The speed is that of the first controller with something to run, in a block of the size
    that the plan uses, in this process.
    """
    speeds: dict[str, float] = {}
    total = 0.0
    for key, configuration in {each.key: each for each in plan.configurations}.items():
        todo = len(plan.todo.get(key, ()))
        if todo == 0:
            continue
        scenario = configuration.scenario
        known = f"{scenario.name} {scenario.task.n_robots}"
        if known not in speeds:
            speeds[known] = seconds_per_tick(configuration)
        total += todo * scenario.n_ticks * speeds[known]
    return total / workers


def seconds_per_tick(configuration: Configuration) -> float:
    """Computing time of one tick of one world, in a block of a usual size [s]."""
    warm_up(configuration)
    n_worlds = max(1, MAX_ROWS // configuration.scenario.task.n_robots)
    loop = start_loop(
        configuration.scenario, configuration.recipe, range(n_worlds), configuration.physics
    )
    run_for(loop, PROBE)
    ticks, seconds = run_for(loop, PROBE)
    return seconds / ticks / n_worlds


def run_for(loop: ControlLoop | WaypointsLoop, seconds: float) -> tuple[int, float]:
    """Run a loop for about this computing time; ticks made, and the time they took [s]."""
    ticks, begin = 0, time.perf_counter()
    while (spent := time.perf_counter() - begin) < seconds:
        for _ in range(BEAT):
            loop.step()
        ticks += BEAT
    return ticks, spent


def in_words(seconds: float) -> str:
    """A duration as a reader says it.

    >>> in_words(5400.0)
    '1.5 h'
    >>> in_words(90.0)
    '2 min'
    >>> in_words(4.0)
    '4 s'
    """
    sizes: Sequence[tuple[float, str, str]] = ((3600.0, "h", ".1f"), (60.0, "min", ".0f"))
    for size, unit, form in sizes:
        if seconds >= size:
            return f"{seconds / size:{form}} {unit}"
    return f"{seconds:.0f} s"
