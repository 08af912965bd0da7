"""All measurements of the benchmark, as one dictionary of JSON values."""

import json
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from functools import partial
from importlib.metadata import version
from pathlib import Path

from baselines.evaluation.bench.cases import Measured, Tell, all_cases
from baselines.evaluation.bench.speed import case_speeds, stage_shares, thread_gain
from baselines.evaluation.bench.tables import check
from baselines.evaluation.experiment_config import LIBRARIES

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
"""Program that compiles every kernel of an evaluation."""

LONG_RUN = """
import json, sys
from baselines.evaluation.bench.cases import all_cases
from baselines.evaluation.bench.measures import peak_memory
loop = all_cases()[0].start("rigid", quick=True)
for _ in range(int(sys.argv[1]) // 10):
    loop.step()
before = peak_memory()
for _ in range(int(sys.argv[1])):
    loop.step()
print(json.dumps([before, peak_memory()]))
"""
"""Program that prints the peak memory before and after many ticks of es1, with filled caches."""


def seconds(code: str, *arguments: str, repeats: int = REPEATS, cache: str | None = None) -> float:
    """Return the median time [s] of a new Python process that runs the code, its start included."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        _run(code, *arguments, cache=cache)
        times.append(time.perf_counter() - start)
    return statistics.median(times)


def start_up(quick: bool) -> dict[str, float]:
    """Measure the start-up times [s] of imports, without Python's own start, and of commands."""
    timed = partial(seconds, repeats=3 if quick else REPEATS)
    empty = timed("pass")
    environment = "import swarm_forage_env; swarm_forage_env.parallel_env"
    return {
        "import": timed("import swarm_forage_env") - empty,
        "import_with_environment": timed(environment) - empty,
        "help": timed(COMMAND, "--help"),
        "list": timed(COMMAND, "list"),
    }


def memory_growth(ticks: int) -> tuple[float, float]:
    """Measure the peak memory of a process [MB] and its growth over this many ticks of es1."""
    before, after = json.loads(_run(LONG_RUN, str(ticks)))
    return after, after - before


def peak_memory() -> float:
    """Return the peak memory of this process so far [MB].

    On Linux it is VmHWM, because getrusage starts at the peak of the parent process.
    """
    status = Path("/proc/self/status")
    if status.exists():
        _, _, rest = status.read_text().partition("VmHWM:")
        return int(rest.split()[0]) / 2**10
    if sys.platform == "win32":
        return float("nan")  # Windows has no getrusage
    import resource

    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / 2 ** (20 if sys.platform == "darwin" else 10)


def _run(code: str, *arguments: str, cache: str | None = None) -> str:
    environment = os.environ | ({"XDG_CACHE_HOME": cache} if cache else {})
    command = sys.executable, "-c", code, *arguments
    ended = subprocess.run(command, env=environment, check=True, text=True, capture_output=True)
    return ended.stdout


ENGINES = ("rigid", "kinematic")
STAGED = ("es1 x 30", "es3", "es3 x 100")  # cases whose stages are timed
THREADED = "es1 x 64"  # the case that is run on several threads

MEMORY_TICKS, QUICK_MEMORY_TICKS = 1_000_000, 5_000


def measure(quick: bool, threads: int, tell: Tell) -> Measured:
    """Run every benchmark; `tell` receives the name of each before it starts."""
    machine = {"python": platform.python_version(), "cores": os.cpu_count()}
    machine |= {library: version(library) for library in LIBRARIES}
    measured: Measured = {"quick": quick, "machine": machine, **_processes(quick, tell)}
    measured |= {"speeds": [], "stages": [], "threads": []}
    for case in all_cases():
        tell(f"speed of {case.name}")
        measured["speeds"].append(case_speeds(case, quick))
        for physics in ENGINES if case.name in STAGED else ():
            tell(f"stages of {case.name}, {physics}")
            shares = stage_shares(case, physics, quick)
            measured["stages"].append({"case": case.name, "physics": physics, "shares": shares})
        for physics in ENGINES if case.name == THREADED else ():
            tell(f"{threads} threads, {physics}")
            gain = thread_gain(case, physics, threads, quick)
            measured["threads"].append({"physics": physics, "threads": threads, "gain": gain})
    measured["peak_memory_mb"] = peak_memory()
    measured["budgets"] = check(measured)
    return measured


def _processes(quick: bool, tell: Tell) -> Measured:
    tell("start-up")
    times = start_up(quick)
    if not quick:
        tell("the first run, which compiles")
        with tempfile.TemporaryDirectory() as cache:
            times["first_run"] = seconds(FIRST_RUN, repeats=1, cache=cache)
    ticks = QUICK_MEMORY_TICKS if quick else MEMORY_TICKS
    tell(f"memory over {ticks:,} ticks")
    peak, growth = memory_growth(ticks)
    memory = {"ticks": ticks, "peak_mb": peak, "growth_mb": growth}
    return {"start_up_s": times, "memory": memory}
