"""Speed of worlds on a GPU, over the number of worlds; beside it the CPU with all its threads."""

import os
import time
from collections.abc import Callable
from typing import Any

from rich.table import Table

from baselines.evaluation.bench.cases import CONTROLLER, Case, Tick
from baselines.evaluation.bench.speed import seconds_per_tick
from baselines.evaluation.experiment_config import find_layered_controller
from swarm_forage_env.device_loop import DeviceLoop, usable_gpu
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.loop import Loop
from swarm_forage_env.scenarios import find_scenario

N_WORLDS = {"es1": (1, 10, 100, 1_000, 10_000, 100_000), "es3": (1, 10, 100, 1_000)}
"""Numbers of worlds of each scenario that are timed."""

QUICK_WORLDS = 1_000
"""The most worlds of a quick run."""

TICKS = 10
"""Ticks of the GPU between two that the CPU waits for."""

Tell = Callable[[str], None]


def measure_gpu(quick: bool, tell: Tell) -> list[dict[str, Any]]:
    """Robot-steps per second of `ssgikf` on a GPU and on all threads of the CPU, `kinematic`.

    ConfigError where there is no GPU.
    """
    usable_gpu()
    threads = os.cpu_count() or 1
    found = []
    for name, numbers in N_WORLDS.items():
        scenario: Scenario = find_scenario(name)
        for n_worlds in numbers:
            if not quick or n_worlds <= QUICK_WORLDS:
                tell(f"{n_worlds} worlds of {name}")
                case = Case(f"{name} x {n_worlds}", scenario, n_worlds)
                found.append(_speeds(case, threads, quick))
    return found


def gpu_table(found: list[dict[str, Any]]) -> Table:
    """What was measured, a row for each number of worlds."""
    table = Table(title="Million robot-steps per second, kinematic, ssgikf")
    for column in ("worlds", "GPU", "CPU", "threads of the CPU", "first ticks on the GPU [s]"):
        table.add_column(column, justify="right")
    for each in found:
        speeds = (f"{each[device] / 1e6:.3g}" for device in ("gpu", "cpu"))
        table.add_row(each["case"], *speeds, str(each["threads"]), f"{each['first_ticks_s']:.1f}")
    return table


def _speeds(case: Case, threads: int, quick: bool) -> dict[str, Any]:
    """One number of worlds, which run for a while on the GPU before both are timed."""
    controller = find_layered_controller(CONTROLLER)
    loop = Loop(case.scenario, controller, range(case.n_worlds), "kinematic", threads)
    start = time.perf_counter()
    there = DeviceLoop(loop)
    tick = _ticks(there)
    tick()
    first = time.perf_counter() - start
    for _ in range(case.n_warm_up(quick) // TICKS):
        tick()
    there.download()
    gpu = seconds_per_tick(tick, quick) / TICKS
    cpu = seconds_per_tick(loop.step, quick)
    return {
        "case": case.name,
        "rows": case.rows,
        "gpu": case.rows / gpu,
        "cpu": case.rows / cpu,
        "threads": threads,
        "first_ticks_s": first,
    }


def _ticks(loop: DeviceLoop) -> Tick:
    """Some ticks of the GPU, for which the CPU then waits."""

    def run() -> None:
        for _ in range(TICKS):
            loop.step()
        loop.check()

    return run
