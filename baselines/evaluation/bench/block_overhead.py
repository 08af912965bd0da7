"""What a block costs beside its episodes: to send it to a worker and back, and to keep them.

    python -m baselines.evaluation.bench.block_overhead --workers 2

A block of `es1` is run once; joblib and a local Ray cluster send its episodes there and back.
"""

import time
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated

import typer

from baselines.evaluation.backends import Backend, JoblibBackend
from baselines.evaluation.console import say
from baselines.evaluation.dataset import Dataset
from baselines.evaluation.episode import AnyEpisode, run_episodes
from baselines.evaluation.experiment_config import ExperimentConfig, find_layered_controller
from baselines.evaluation.ray_backend import RayBackend
from baselines.evaluation.runner import MAX_ROWS, Plan, warm_up
from swarm_forage_env.scenarios import find_scenario

Job = tuple[int, Sequence[AnyEpisode]]


def echo(job: Job) -> Job:
    """What a worker does here: nothing."""
    return job


def seconds_per_call(backend: Backend, jobs: list[Job]) -> tuple[float, float]:
    """Time until the first call of all has ended, and mean time of one of the rest [s]."""
    begin = time.perf_counter()
    with closing(backend.run(echo, jobs)) as finished:
        next(finished)
        first = time.perf_counter()
        for _ in finished:
            pass
    return first - begin, (time.perf_counter() - first) / (len(jobs) - 1)


def seconds_to_keep(
    configuration: ExperimentConfig, episodes: Sequence[AnyEpisode], times: int
) -> float:
    """Mean time in which this process keeps the episodes of a block on this disk [s]."""
    with TemporaryDirectory(dir=Path.cwd()) as folder:
        plan = Plan([configuration], (), Dataset(Path(folder)))
        begin = time.perf_counter()
        for _ in range(times):
            plan.keep(configuration.key, episodes)
        return (time.perf_counter() - begin) / times


def main(
    blocks: Annotated[int, typer.Option(min=2, help="Calls of each backend.")] = 500,
    workers: Annotated[int, typer.Option(min=2, help="Worker processes.")] = 2,
    rounds: Annotated[int, typer.Option(min=1, help="Times that each backend is measured.")] = 3,
) -> None:
    """Measure what a block costs beside its episodes, on joblib and on a local Ray cluster."""
    scenario = find_scenario("es1")
    configuration = ExperimentConfig("ssgikf", scenario, find_layered_controller("ssgikf"))
    seeds = range(MAX_ROWS // scenario.task.n_robots)
    warm_up(configuration)
    say(f"a block: {len(seeds)} episodes of es1, ssgikf, {configuration.physics}")
    begin = time.perf_counter()
    episodes = run_episodes(scenario, configuration.controller, seeds, configuration.physics)
    typer.echo(f"to run a block: {time.perf_counter() - begin:.2f} s")
    typer.echo(f"to keep its episodes: {seconds_to_keep(configuration, episodes, 10):.3f} s")
    jobs: list[Job] = [(number, episodes) for number in range(blocks)]
    backends: tuple[Backend, ...] = JoblibBackend(workers), RayBackend(workers)
    for _ in range(rounds):
        for backend in backends:
            start, each = seconds_per_call(backend, jobs)
            name = type(backend).__name__.removesuffix("Backend")
            typer.echo(f"{name}: first call after {start:.2f} s, then {1e3 * each:.2f} ms a block")


if __name__ == "__main__":
    typer.run(main)
