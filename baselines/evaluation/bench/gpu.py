"""Benchmark of worlds on a GPU: speed, stages, memory traffic and energy, compared with the CPU."""

import ctypes
import os
import time
from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec
from itertools import count

import numpy as np

from baselines.evaluation.bench.cases import CONTROLLER, Case, Measured, Tell, Tick
from baselines.evaluation.bench.speed import seconds_per_tick
from baselines.evaluation.experiment_config import find_layered_controller
from swarm_forage_env.device_loop import DeviceLoop
from swarm_forage_env.device_memory import usable_gpu
from swarm_forage_env.envs.array_env import array_env
from swarm_forage_env.loop import Loop
from swarm_forage_env.scenarios import find_scenario

N_WORLDS = {"es1": (1, 10, 100, 1_000, 10_000, 100_000), "es3": (1, 10, 100, 1_000)}
"""Timed numbers of worlds by scenario."""

QUICK_WORLDS = 1_000  # largest number of worlds in a quick run
TICKS = 100  # ticks per launch
DECISIONS = 10  # decisions between two waits of the CPU for the GPU


def measure_gpu(quick: bool, tell: Tell) -> list[Measured]:
    """Measure robot-steps per second of `ssgikf`, `kinematic`, on a GPU and on all CPU threads.

    The time of the first step includes the creation of the worlds and the compilation. Raises
    ConfigError without a GPU.
    """
    usable_gpu()
    threads = os.cpu_count() or 1
    measured = []
    for name, n_worlds in ((name, n) for name, numbers in N_WORLDS.items() for n in numbers):
        if quick and n_worlds > QUICK_WORLDS:
            continue
        tell(f"{n_worlds} worlds of {name}")
        case = Case(f"{name} x {n_worlds}", find_scenario(name), n_worlds)
        vmas = vmas_seconds(n_worlds, quick) if name == "es1" else None
        measured.append(measure_case(case, threads, quick) | {"vmas": vmas and case.rows / vmas})
    return measured


def measure_case(case: Case, threads: int, quick: bool) -> Measured:
    """Measure one case on the GPU and on the CPU, after a warm-up on the GPU."""
    controller = find_layered_controller(CONTROLLER)
    start, seeds = time.perf_counter(), range(case.n_worlds)
    loop = Loop(case.scenario, controller, seeds, "kinematic", threads, is_blank=True)
    there = DeviceLoop(loop)
    there.reset(seeds)
    there.step()
    there.check()
    first = time.perf_counter() - start

    def tick() -> None:
        there.run(TICKS)
        there.check()

    for _ in range(case.n_warm_up(quick) // TICKS):
        tick()
    there.download()
    gpu, joules = _timed_with_energy(tick, quick)
    cpu = seconds_per_tick(loop.step, quick)
    made, learning = seconds_in_environment(case, quick)
    return {
        "case": case.name,
        "rows": case.rows,
        "gpu": case.rows / gpu,
        "cpu": case.rows / cpu,
        "environment": case.rows / learning,
        "made_s": made,
        "threads": threads,
        "joules_per_million": None if joules is None else joules / case.rows * 1e6,
        "first_step_s": first,
        **_memory(there, case.rows),
    }


def seconds_in_environment(case: Case, quick: bool) -> tuple[float, float]:
    """Measure the times to create and reset an environment, and of a tick through its arrays [s].

    The motion is learned, without a network. A tick includes the checks of actions, observations,
    rewards and resets; the worlds end at different times.
    """
    start = time.perf_counter()
    env = array_env(
        case.scenario, device="cuda", n_worlds=case.n_worlds, learn="motion",
        physics="kinematic", controller=CONTROLLER, stagger=True,
    )  # fmt: skip
    env.reset(seed=0)
    env.check()  # waits for the GPU
    made = time.perf_counter() - start
    shape = case.n_worlds, len(env.learners), len(env.action_layout)
    actions = env.memory.to_device(np.zeros(shape, np.float32))
    outputs = env.step_and_reset(actions).outputs

    def steps() -> None:
        for _ in range(DECISIONS):
            env.step_and_reset(actions, outputs)
        env.check()  # waits for the GPU

    return made, seconds_per_tick(steps, quick) / (DECISIONS * int(env.config.period))


def vmas_seconds(n_worlds: int, quick: bool, device: str = "cuda") -> float | None:
    """Return the time of a step of VMAS's navigation [s], 10 agents, 8 rays; None without VMAS."""
    if find_spec("vmas") is None:
        return None
    env = import_module("vmas").make_env(
        scenario="navigation", num_envs=n_worlds, device=device, continuous_actions=True,
        n_agents=10, n_lidar_rays=8,
    )  # fmt: skip
    env.reset()
    actions = [env.get_random_action(agent) for agent in env.agents]

    def step() -> None:
        _, rewards, *_ = env.step(actions)
        rewards[0].sum().item()  # waits for the GPU

    return seconds_per_tick(step, quick)


def _timed_with_energy(tick: Tick, quick: bool) -> tuple[float, float | None]:
    """Return the time [s] and the energy [J] of a tick on the GPU; energy None if not reported."""
    meter = energy_meter(usable_gpu().get_current_device().uuid)
    calls, before = count(), meter and meter()

    def counted() -> None:
        tick()
        next(calls)

    seconds = seconds_per_tick(counted, quick) / TICKS
    joules = meter() - before if meter and before is not None else None
    return seconds, joules and joules / (next(calls) * TICKS)


def _memory(loop: DeviceLoop, rows: int) -> Measured:
    """Return the time share of each stage and the memory traffic, from events of the GPU."""
    seconds = stage_seconds(loop)
    total, n_bytes = sum(seconds.values()), sum(loop.traffic.values())
    card = card_bandwidth(usable_gpu().get_current_device())
    bandwidth = n_bytes / total if total > 0.0 else None
    return {
        "shares": {stage: each / total for stage, each in seconds.items() if total > 0.0},
        "bytes_per_robot_step": n_bytes / rows,
        "bandwidth": bandwidth,
        "share_of_card": bandwidth / card if bandwidth and card else None,
    }


def stage_seconds(loop: DeviceLoop) -> dict[str, float]:
    """Return the mean time of each stage of a tick [s]; zeros in a simulator without a clock."""
    ticks = []
    for _ in range(DECISIONS):
        marks = [loop.memory.mark()]
        for run in loop.stages.values():
            run()
            marks.append(loop.memory.mark())
        ticks.append(marks)
    marks[-1].synchronize()  # codespell:ignore
    means = (
        sum(marks[k].elapsed_time(marks[k + 1]) for marks in ticks) / DECISIONS / 1e3
        for k in range(len(loop.stages))
    )
    return dict(zip(loop.stages, means, strict=True))


def card_bandwidth(device: object) -> float | None:
    """Return the bandwidth of a GPU's double-data-rate memory [byte/s]; None if not reported."""
    clock = getattr(device, "MEMORY_CLOCK_RATE", None)  # [kHz]
    width = getattr(device, "GLOBAL_MEMORY_BUS_WIDTH", None)  # [bit]
    return 2.0 * clock * 1e3 * width / 8.0 if clock and width else None


def energy_meter(uuid: str, library: ctypes.CDLL | None = None) -> Callable[[], float] | None:
    """Return a function that reads the energy [J] used by a GPU since its driver was loaded.

    None if the driver does not report it: on another system than Linux, or a GPU before Volta.
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
