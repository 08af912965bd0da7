"""Benchmarks that need a process of their own: start-up, compilation, memory."""

import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

REPEATS = 5

COMMAND = "from training.cli import main; main()"

FIRST_RUN = """
from baselines.evaluation.bench.cases import all_cases
from baselines.evaluation.experiment_config import ExperimentConfig, find_layered_controller
from baselines.evaluation.runner import warm_up
es1 = all_cases()[0].scenario
for physics in ("rigid", "kinematic"):
    warm_up(ExperimentConfig("ssgikf", es1, find_layered_controller("ssgikf"), physics))
"""
"""Compiles every kernel of an evaluation."""

LONG_RUN = """
import json, sys
from baselines.evaluation.bench.cases import all_cases
from baselines.evaluation.bench.processes import peak_memory
loop = all_cases()[0].start("rigid", quick=True)
for _ in range(int(sys.argv[1]) // 10):
    loop.step()
before = peak_memory()
for _ in range(int(sys.argv[1])):
    loop.step()
print(json.dumps([before, peak_memory()]))
"""
"""Peak memory before and after many ticks of es1; the first ones fill caches."""


def seconds(code: str, *arguments: str, repeats: int = REPEATS, cache: str | None = None) -> float:
    """Median time [s] of a new Python process that runs this code, its start included."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        _run(code, *arguments, cache=cache)
        times.append(time.perf_counter() - start)
    return statistics.median(times)


def start_up(quick: bool) -> dict[str, float]:
    """Start-up times [s] of import and commands; for the import, without Python's own."""
    repeats = 3 if quick else REPEATS
    empty = seconds("pass", repeats=repeats)
    return {
        "import": seconds("import swarm_forage_env", repeats=repeats) - empty,
        "import_with_environment": seconds(
            "import swarm_forage_env; swarm_forage_env.parallel_env", repeats=repeats
        )
        - empty,
        "help": seconds(COMMAND, "--help", repeats=repeats),
        "list": seconds(COMMAND, "list", repeats=repeats),
    }


def first_run() -> float:
    """Time of the first run after installation [s]: everything compiles."""
    with tempfile.TemporaryDirectory() as cache:
        return seconds(FIRST_RUN, repeats=1, cache=cache)


def memory_growth(ticks: int) -> tuple[float, float]:
    """Peak memory of a process [MB] and by how much it grew over so many ticks of es1."""
    before, after = json.loads(_run(LONG_RUN, str(ticks)))
    return after, after - before


def peak_memory() -> float:
    """Peak memory of this process so far [MB].

    What the system counts of a process begins, on Linux, with the peak of the process that started
    it; so there the peak of its own memory is read instead.
    """
    status = Path("/proc/self/status")
    if status.exists():
        peak = next(line for line in status.read_text().splitlines() if line.startswith("VmHWM:"))
        return int(peak.split()[1]) / 2**10
    import resource

    peak_kept = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak_kept / 2 ** (20 if sys.platform == "darwin" else 10)


def _run(code: str, *arguments: str, cache: str | None = None) -> str:
    environment: dict[str, Any] = dict(os.environ)
    if cache is not None:
        environment["XDG_CACHE_HOME"] = cache
    return subprocess.run(
        [sys.executable, "-c", code, *arguments],
        env=environment, check=True, text=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
    ).stdout  # fmt: skip
