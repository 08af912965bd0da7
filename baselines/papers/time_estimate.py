"""Estimate the run time of a plan from a short run of each scenario."""

import time
from collections.abc import Sequence

from baselines.evaluation.experiment_config import ExperimentConfig
from baselines.evaluation.runner import MAX_ROWS, Plan, warm_up
from swarm_forage_env.loop import Loop

PROBE = 0.3
"""Computing time of a probe, and as much again to let the robots meet [s]."""

BEAT = 20
"""Ticks between two looks at the clock."""


def expected_seconds(plan: Plan, workers: int) -> float:
    """Expected time of the episodes still to run [s], from the speed of each scenario.

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


def seconds_per_tick(configuration: ExperimentConfig) -> float:
    """Computing time of one tick of one world, in a block of a usual size [s]."""
    warm_up(configuration)
    n_worlds: int = max(1, MAX_ROWS // configuration.scenario.task.n_robots)
    scenario, controller = configuration.scenario, configuration.controller
    loop = Loop(scenario, controller, range(n_worlds), configuration.physics)
    run_for(loop, PROBE)
    ticks, seconds = run_for(loop, PROBE)
    return seconds / ticks / n_worlds


def run_for(loop: Loop, seconds: float) -> tuple[int, float]:
    """Run a loop for about this computing time; return the ticks and the time they took [s]."""
    ticks, begin = 0, time.perf_counter()
    while (spent := time.perf_counter() - begin) < seconds:
        loop.run(BEAT)
        ticks += BEAT
    return ticks, spent


def format_duration(seconds: float) -> str:
    """Format a duration for a reader.

    >>> format_duration(5400.0)
    '1.5 h'
    >>> format_duration(90.0)
    '2 min'
    >>> format_duration(4.0)
    '4 s'
    """
    sizes: Sequence[tuple[float, str, str]] = ((3600.0, "h", ".1f"), (60.0, "min", ".0f"))
    for size, unit, form in sizes:
        if seconds >= size:
            return f"{seconds / size:{form}} {unit}"
    return f"{seconds:.0f} s"
