"""Speed of worlds on a GPU over their number, its stages, memory and energy; beside it the CPU."""

import ctypes
import os
import time
from collections.abc import Callable
from itertools import count

import numpy as np
from rich.console import Group
from rich.text import Text

from baselines.evaluation.bench.cases import CONTROLLER, Case, Measured, Tell, Tick
from baselines.evaluation.bench.speed import seconds_per_tick
from baselines.evaluation.experiment_config import find_layered_controller
from baselines.evaluation.tables import FittingTable
from swarm_forage_env.device_loop import DeviceLoop
from swarm_forage_env.device_memory import usable_gpu
from swarm_forage_env.envs.array_env import array_env
from swarm_forage_env.loop import Loop
from swarm_forage_env.scenarios import find_scenario

N_WORLDS = {"es1": (1, 10, 100, 1_000, 10_000, 100_000), "es3": (1, 10, 100, 1_000)}
"""Numbers of worlds of each scenario that are timed."""

QUICK_WORLDS = 1_000  # the most worlds of a quick run
MAKING = 3e-4  # time in which a CPU makes a world [s]: 0.28 ms beside an H200, 23 November 2026
TICKS = 10  # ticks of the GPU between two that the CPU waits for


def measure_gpu(quick: bool, tell: Tell) -> list[Measured]:
    """Robot-steps per second of `ssgikf` on a GPU and on all threads of the CPU, `kinematic`.

    The time of the first step includes the upload and the compilation. ConfigError without a GPU.
    """
    usable_gpu()
    threads = os.cpu_count() or 1
    measured = []
    for name, n_worlds in ((name, n) for name, numbers in N_WORLDS.items() for n in numbers):
        is_large = n_worlds > QUICK_WORLDS
        if quick and is_large:
            continue
        wait = f", made in about {MAKING * n_worlds:.0f} s" if is_large else ""
        tell(f"{n_worlds} worlds of {name}{wait}")
        case = Case(f"{name} x {n_worlds}", find_scenario(name), n_worlds)
        measured.append(measure_case(case, threads, quick))
    return measured


def measure_case(case: Case, threads: int, quick: bool) -> Measured:
    """One number of worlds, which run for a while on the GPU before both are timed."""
    controller = find_layered_controller(CONTROLLER)
    loop = Loop(case.scenario, controller, range(case.n_worlds), "kinematic", threads)
    start = time.perf_counter()
    there = DeviceLoop(loop)
    there.step()
    there.check()
    first = time.perf_counter() - start

    def tick() -> None:
        for _ in range(TICKS):
            there.step()
        there.check()

    for _ in range(case.n_warm_up(quick) // TICKS):
        tick()
    there.download()
    gpu, joules = _timed_with_energy(tick, quick)
    cpu = seconds_per_tick(loop.step, quick)
    return {
        "case": case.name,
        "rows": case.rows,
        "gpu": case.rows / gpu,
        "cpu": case.rows / cpu,
        "environment": case.rows / seconds_in_environment(case, quick),
        "threads": threads,
        "joules_per_million": None if joules is None else joules / case.rows * 1e6,
        "first_step_s": first,
        **_memory(there, case.rows),
    }


def seconds_in_environment(case: Case, quick: bool) -> float:
    """Mean time of a tick [s] as a learner of the motion has it, on the arrays of a GPU."""
    env = array_env(
        case.scenario, device="cuda", n_worlds=case.n_worlds, learn="motion",
        physics="kinematic", controller=CONTROLLER, stagger=True,
    )  # fmt: skip
    env.reset(seed=0)
    shape = case.n_worlds, len(env.learners), len(env.action_layout)
    actions = env.memory.to_device(np.zeros(shape, np.float32))
    room = env.step_and_reset(actions).room

    def steps() -> None:
        for _ in range(TICKS):
            env.step_and_reset(actions, room)
        env.check()  # waits for the GPU

    return seconds_per_tick(steps, quick) / (TICKS * int(env.config.period))


def _timed_with_energy(tick: Tick, quick: bool) -> tuple[float, float | None]:
    """Time of one tick of the GPU [s], and its energy [J]; None if not reported."""
    meter = energy_meter(usable_gpu().get_current_device().uuid)
    calls, before = count(), meter and meter()

    def counted() -> None:
        tick()
        next(calls)

    seconds = seconds_per_tick(counted, quick) / TICKS
    joules = meter() - before if meter and before is not None else None
    return seconds, joules and joules / (next(calls) * TICKS)


def _memory(loop: DeviceLoop, rows: int) -> Measured:
    """The share of each stage, and what it means for the memory, by events of the GPU."""
    seconds = stage_seconds(loop)
    whole, n_bytes = sum(seconds.values()), sum(loop.traffic.values())
    card = card_bandwidth(usable_gpu().get_current_device())
    bandwidth = n_bytes / whole if whole > 0.0 else None
    return {
        "shares": {stage: each / whole for stage, each in seconds.items() if whole > 0.0},
        "bytes_per_robot_step": n_bytes / rows,
        "bandwidth": bandwidth,
        "share_of_card": bandwidth / card if bandwidth and card else None,
    }


def stage_seconds(loop: DeviceLoop) -> dict[str, float]:
    """Mean time of each stage of a tick [s]; zeros in a simulator, which has no clock."""
    ticks = []
    for _ in range(TICKS):
        marks = [loop.memory.mark()]
        for run in loop.stages.values():
            run()
            marks.append(loop.memory.mark())
        ticks.append(marks)
    marks[-1].synchronize()  # codespell:ignore
    means = (
        sum(marks[k].elapsed_time(marks[k + 1]) for marks in ticks) / TICKS / 1e3
        for k in range(len(loop.stages))
    )
    return dict(zip(loop.stages, means, strict=True))


def card_bandwidth(device: object) -> float | None:
    """The bandwidth of a GPU's memory, of double data rate [byte/s]; None if not reported."""
    clock = getattr(device, "MEMORY_CLOCK_RATE", None)  # [kHz]
    width = getattr(device, "GLOBAL_MEMORY_BUS_WIDTH", None)  # [bit]
    return 2.0 * clock * 1e3 * width / 8.0 if clock and width else None


def energy_meter(uuid: str, library: ctypes.CDLL | None = None) -> Callable[[], float] | None:
    """Reads the energy [J] that the GPU of this UUID has used since its driver was loaded.

    None where the driver does not report it: another system, or a GPU older than Volta.
    """
    try:
        nvml = library or ctypes.CDLL("libnvidia-ml.so.1")
    except OSError:
        return None
    gpu, used = ctypes.c_void_p(), ctypes.c_ulonglong()

    def read() -> bool:
        return bool(nvml.nvmlDeviceGetTotalEnergyConsumption(gpu, ctypes.byref(used)) == 0)

    is_found = (
        nvml.nvmlInit_v2() == 0
        and nvml.nvmlDeviceGetHandleByUUID(uuid.encode(), ctypes.byref(gpu)) == 0
    )
    if not is_found or not read():
        return None

    def joules() -> float:
        read()
        return used.value / 1e3

    return joules


def gpu_table(measured: list[Measured]) -> Group:
    """Table with a row for each number of worlds; a dash for what the driver does not report."""
    rows = [_cells(each) for each in measured]
    columns = {heading: [Text(row[heading]) for row in rows] for heading in rows[0]}
    return Group(
        Text("Worlds on a GPU: kinematic, ssgikf; millions of robot-steps a second", style="bold"),
        FittingTable("worlds", [each["case"] for each in measured], columns),
        Text(
            "Bytes are those of the records that the kernels are handed, each read or written"
            " once. Energy is in joules per million robot-steps. Learning: by the arrays of an"
            " environment whose motion is learned, without a network.",
            style="dim",
        ),
    )


def _cells(each: Measured) -> dict[str, str]:
    return {
        "GPU": _millions(each["gpu"]),
        "learning": _millions(each["environment"]),
        "CPU": _millions(each["cpu"]),
        "threads": str(each["threads"]),
        **{
            stage: _or_dash(each["shares"].get(stage), ".0%")
            for stage in ("decide", "tick", "observe")
        },
        "bytes": f"{each['bytes_per_robot_step']:.0f}",
        "GB/s": _or_dash(each["bandwidth"], ".0f", 1e-9),
        "of card": _or_dash(each["share_of_card"], ".0%"),
        "J": _or_dash(each["joules_per_million"], ".3g"),
        "first [s]": f"{each['first_step_s']:.1f}",
    }


def _millions(speed: float) -> str:
    millions = speed / 1e6
    return f"{millions:,.0f}" if millions >= 100.0 else f"{millions:.3g}"


def _or_dash(number: float | None, form: str, scale: float = 1.0) -> str:
    return "-" if number is None else format(number * scale, form)
