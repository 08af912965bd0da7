"""Run the episodes that a dataset does not hold yet, in parallel.

Episodes run in blocks of worlds, spread over worker processes; a worker writes the episodes of
a block as soon as the block ends. The worlds of a block may share several threads. Neither how
episodes are cut into blocks nor the number of threads ever changes a result.
"""

import os
import signal
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from joblib import Parallel, delayed

from baselines.evaluation.dataset import Dataset
from baselines.evaluation.episode import run_episodes
from baselines.evaluation.experiment_config import ExperimentConfig
from baselines.evaluation.trajectories import Trajectories, TrajectoryRecorder
from swarm_forage_env.loop import Loop

MAX_ROWS = 300
"""Robots in a block for each thread, about: more rows hardly share Python's cost per tick any
further."""

WARM_UP_TICKS = 50
"""Long enough for bodies to touch, which the engine `rigid` has a kernel for."""

ROUNDS = 2
"""Blocks for each worker, at least, so that all have work until near the end."""


@dataclass(frozen=True)
class Block:
    """Episodes of one configuration that run side by side in one process."""

    configuration: ExperimentConfig
    seeds: tuple[int, ...]


Stores = tuple[Dataset, Trajectories | None]
"""Where episodes are kept, and their trajectories, if they are."""


class Plan:
    """The episodes wanted: those found in the dataset, and those still to run."""

    def __init__(
        self,
        configurations: Sequence[ExperimentConfig],
        seeds: Sequence[int],
        dataset: Dataset,
        trajectories: Trajectories | None = None,
    ) -> None:
        """Look for every episode in the dataset, with its trajectory if asked; nothing runs yet."""
        self.configurations = list(configurations)
        self.seeds = list(seeds)
        self.dataset = dataset
        self.trajectories = trajectories
        self.episodes: dict[tuple[str, int], Any] = {}
        self.todo: dict[str, list[int]] = {}
        self._named = {each.key: each for each in configurations}
        for key, configuration in self._named.items():
            for seed in seeds:
                episode = dataset.find(configuration, seed)
                if episode is None or not (
                    trajectories is None or trajectories.holds(configuration, seed)
                ):
                    self.todo.setdefault(key, []).append(seed)
                else:
                    self.episodes[key, seed] = episode

    @property
    def n_todo(self) -> int:
        """Number of episodes still to run."""
        return sum(map(len, self.todo.values()))

    def blocks(self, workers: int, threads: int = 1) -> list[Block]:
        """The episodes still to run, cut into blocks of nearly equal size."""
        share = -(-self.n_todo // (ROUNDS * workers))
        return [
            Block(self._named[key], tuple(seeds.tolist()))
            for key, todo in self.todo.items()
            for seeds in _cut(todo, min(share, threads * self._room(key)))
        ]

    def run(self, workers: int, threads: int = 1) -> Iterator[int]:
        """Run the missing episodes; yield after each block how many episodes it held."""
        blocks = self.blocks(workers, threads)
        if not blocks:
            return
        for block in {block.configuration.key: block for block in blocks}.values():
            warm_up(block.configuration)
        workers = min(workers, len(blocks))
        parallel = Parallel(n_jobs=workers, return_as="generator_unordered", batch_size=1)
        with ignore_sigint():
            finished = parallel(
                delayed(_run_block)(block, self._stores, threads, os.getpid()) for block in blocks
            )
        with closing(finished):  # ends the workers, whatever happens
            for key, episodes in finished:
                for episode in episodes:
                    self.episodes[key, episode.seed] = episode
                yield len(episodes)

    def results(self) -> list[Any]:
        """All episodes, by controller, then seed, under the controllers' names as given."""
        return [
            replace(self.episodes[each.key, seed], controller=each.label)
            for each in self.configurations
            for seed in self.seeds
        ]

    @property
    def files(self) -> list[Path]:
        """The file of every episode, whether it exists or not, by controller, then seed."""
        return [self.dataset.place(each, s) for each in self.configurations for s in self.seeds]

    @property
    def _stores(self) -> "Stores":
        return self.dataset, self.trajectories

    def _room(self, key: str) -> int:
        """Number of worlds of this configuration that a thread of a block has room for."""
        n_robots: int = self._named[key].scenario.task.n_robots
        return max(1, MAX_ROWS // n_robots)


def evaluate(
    configurations: Sequence[ExperimentConfig],
    seeds: Sequence[int],
    dataset: Dataset,
    workers: int = 1,
    threads: int = 1,
    progress: Callable[[int], None] = lambda _: None,
) -> list[Any]:
    """Run or find the episodes of all configurations under all seeds, and keep them."""
    plan = Plan(configurations, seeds, dataset)
    for done in plan.run(workers, threads):
        progress(done)
    return plan.results()


def warm_up(configuration: ExperimentConfig) -> None:
    """Compile every kernel of a configuration, so that workers find them cached."""
    scenario, controller = configuration.scenario, configuration.controller
    loop = Loop(scenario, controller, (0,), configuration.physics)
    meter = loop.task.episode.meter(loop)
    for tick in range(1, min(WARM_UP_TICKS, scenario.n_ticks) + 1):
        loop.step()
        meter.sample(tick)


def _cut(seeds: Sequence[int], size: int) -> list[np.ndarray]:
    """Cut the seeds into parts of nearly equal size, none larger than `size`."""
    return np.array_split(np.asarray(seeds, dtype=np.uint64), -(-len(seeds) // size))


@contextmanager
def ignore_sigint() -> Iterator[None]:
    """Start workers that ignore SIGINT; the parent process handles it and stops them."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


@cache
def end_with(parent: int) -> None:
    """Let a worker end within a second of its parent process, which may be killed."""
    if os.getppid() == parent:
        threading.Thread(target=_watch, args=(parent,), daemon=True).start()


def _watch(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(0.5)
    os._exit(1)


def _run_block(block: Block, stores: Stores, threads: int, parent: int) -> tuple[str, list[Any]]:
    """Run a block and keep its episodes; the work of one process, a worker or the parent itself."""
    end_with(parent)
    configuration = block.configuration
    what = configuration.scenario, configuration.controller, block.seeds, configuration.physics
    dataset, trajectories = stores
    if trajectories is None:
        episodes = run_episodes(*what, threads)
    else:
        recorder = TrajectoryRecorder(configuration, block.seeds)
        episodes = run_episodes(*what, threads, recorder)
        trajectories.keep(configuration, recorder.contents())
    dataset.keep(configuration, episodes)
    return configuration.key, episodes
