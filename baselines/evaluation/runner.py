"""Run the episodes that a dataset does not hold yet, in parallel.

A backend spreads blocks of episodes over worker processes, and this process writes the episodes as
soon as their block ends. Results depend neither on the blocks nor on the number of threads.
"""

import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from dataclasses import replace
from functools import partial
from itertools import chain
from typing import Any

import numpy as np

from baselines.evaluation.backends import Backend, JoblibBackend, JobT
from baselines.evaluation.console import progress_bar, say
from baselines.evaluation.dataset import Dataset
from baselines.evaluation.episode import AnyEpisode, compile_episodes, run_episodes
from baselines.evaluation.experiment_config import ExperimentConfig
from baselines.evaluation.trajectories import Trajectories, TrajectoryRecorder
from swarm_forage_env.compiler import report_compiling
from swarm_forage_env.worlds_on_cpu import Device

MAX_ROWS = 300
"""Approximate number of robots per thread of a block; more would hardly raise the speed."""

ROWS_ON_GPU = 100_000
"""Number of robots in a block on a GPU: enough that it is never idle; they take about 250 MB."""

ROUNDS = 2  # minimum number of blocks per worker, so that all have work until near the end
WRITERS = 16  # files that this process writes at the same time


EpisodeBlock = tuple[ExperimentConfig, tuple[int, ...]]
"""Configuration, and the seeds of its episodes that run side by side in one process."""


class Plan:
    """Episodes of a command: those that the dataset holds, and those still to run."""

    def __init__(
        self,
        configurations: Sequence[ExperimentConfig],
        seeds: Sequence[int],
        dataset: Dataset,
        trajectories: Trajectories | None = None,
    ) -> None:
        """Look up every episode, and its trajectory if recorded, without running any."""
        self.configurations = list(configurations)
        self.seeds = list(seeds)
        self.dataset = dataset
        self.trajectories = trajectories
        self.todo: dict[str, list[int]] = {}  # seeds by the key of the configuration
        self._named = {each.key: each for each in configurations}
        self._stored: dict[str, dict[int, AnyEpisode]] = {}
        for key, configuration in self._named.items():
            episodes = dataset.find(configuration, seeds)
            self._stored[key] = {
                seed: episode
                for seed, episode in episodes.items()
                if trajectories is None or trajectories.holds(configuration, seed)
            }
            if missing := [seed for seed in seeds if seed not in self._stored[key]]:
                self.todo[key] = missing

    @property
    def n_todo(self) -> int:
        """Number of episodes still to run."""
        return sum(map(len, self.todo.values()))

    def blocks(self, backend: Backend) -> list[EpisodeBlock]:
        """Return the episodes still to run, in blocks of nearly equal size."""
        rounds = ROUNDS * backend.workers if backend.device == "cpu" else 1
        share = -(-self.n_todo // rounds)
        blocks: list[EpisodeBlock] = []
        for key, todo in self.todo.items():
            n_worlds = worlds_in_a_block(self._named[key], backend.device)
            size = min(share, backend.threads * n_worlds)
            for seeds in np.array_split(np.asarray(todo, np.uint64), -(-len(todo) // size)):
                blocks.append((self._named[key], tuple(seeds.tolist())))
        return blocks

    def run(self, backend: Backend, tell: Callable[[str], None] = lambda _: None) -> Iterator[int]:
        """Run the missing episodes; yield the number of episodes of each block once it is written.

        Episodes stored under another name of their controller are written again, as figures show
        it. Those of a block on a GPU are written together. `tell` receives progress of compilation.
        """
        for key, configuration in self._named.items():
            stored = self._stored[key].items()
            renamed = {seed for seed, each in stored if each.controller != configuration.label}
            files = self.dataset.files(configuration).items() if renamed else ()
            for_seeds = [file for seeds, file in files if not renamed.isdisjoint(seeds)]
            _write_in_threads(partial(self.dataset.relabel, configuration), for_seeds)
        missing = [self._named[key] for key in self.todo]
        for number, configuration in enumerate(missing, 1):
            step = f"compiling {number} of {len(missing)}, {configuration.label}"
            with report_compiling(lambda function, step=step: tell(f"{step}: {function}")):  # type: ignore[misc]
                warm_up(configuration, backend.device)
        tell("")
        blocks = self.blocks(backend)
        run = partial(_run_block, backend=backend, is_recorded=self.trajectories is not None)
        with closing(backend.run(run, blocks)) as finished:
            for key, episodes, contents in finished:
                parts = [[each] for each in episodes] if backend.device == "cpu" else [episodes]
                _write_in_threads(partial(self._keep, self._named[key], contents), parts)
                self._stored[key] |= {each.seed: each for each in episodes}
                yield len(episodes)

    def _keep(
        self,
        configuration: ExperimentConfig,
        contents: Mapping[int, bytes],
        episodes: Sequence[AnyEpisode],
    ) -> None:
        """Write episodes after their trajectories, so that every stored episode has one."""
        if self.trajectories:
            for each in episodes:
                place = self.trajectories.place(configuration, each.seed)
                self.trajectories.write(place, contents[each.seed])
        self.dataset.keep(configuration, episodes)

    def results(self) -> list[Any]:
        """Return all episodes, by controller, then seed, with the controllers' names as given."""
        return list(chain.from_iterable(self.by_configuration()))

    def by_configuration(self) -> list[list[Any]]:
        """Return the episodes of each configuration, in their order."""
        return [
            [replace(self._stored[each.key][seed], controller=each.label) for seed in self.seeds]
            for each in self.configurations
        ]


def worlds_in_a_block(configuration: ExperimentConfig, device: Device = "cpu") -> int:
    """Return the number of worlds that fill one thread of a block, or a block on a GPU."""
    n_robots: int = configuration.scenario.task.n_robots
    return max(1, (MAX_ROWS if device == "cpu" else ROWS_ON_GPU) // n_robots)


def evaluate(
    configurations: Sequence[ExperimentConfig],
    seeds: Sequence[int],
    dataset: Dataset,
    backend: Backend | None = None,
) -> list[Any]:
    """Return all episodes; run and store missing ones, in this process without a backend."""
    plan = Plan(configurations, seeds, dataset)
    for _ in plan.run(backend or JoblibBackend()):
        pass
    return plan.results()


def warm_up(configuration: ExperimentConfig, device: Device = "cpu") -> None:
    """Compile every kernel of a configuration, so that workers find them cached."""
    terms = configuration.scenario, configuration.controller, configuration.physics
    compile_episodes(*terms, device)


def _run_block(
    block: EpisodeBlock, backend: Backend, is_recorded: bool
) -> tuple[str, list[AnyEpisode], Mapping[int, bytes]]:
    """Run a block; return the configuration's key, its episodes, and trajectory files by seed."""
    config, seeds = block
    recorder = TrajectoryRecorder(config, seeds) if is_recorded else None
    terms = config.scenario, config.controller, seeds, config.physics
    episodes = run_episodes(*terms, backend.threads, recorder, backend.device)
    return config.key, episodes, recorder.contents() if recorder else {}


def _write_in_threads(function: Callable[[JobT], None], jobs: Iterable[JobT]) -> None:
    """Write files in threads, as they mostly wait for the disk; Ctrl-C waits for all of them."""
    with ThreadPoolExecutor(WRITERS) as pool:
        writes = [pool.submit(function, job) for job in jobs]
    for write in writes:
        write.result()


NAMED = 20  # maximum number of files in a message


def run_with_progress(plan: Plan, backend: Backend) -> None:
    """Run the missing episodes; print a line before and after, a bar if stderr is a terminal."""
    begin, n_todo = time.monotonic(), plan.n_todo
    total = len({each.key for each in plan.configurations}) * len(plan.seeds)
    scenarios = ", ".join(dict.fromkeys(each.scenario.name for each in plan.configurations))
    found_so_far = f"{total - n_todo} of {total} episodes found in {plan.dataset.name}"
    say(f"{scenarios}: {found_so_far}, {n_todo} to run")
    with progress_bar("episodes") as progress:
        bar = progress.add_task("", total=n_todo)
        for n_episodes in plan.run(backend, lambda text: progress.update(bar, description=text)):
            progress.advance(bar, n_episodes)
    say(f"done in {time.monotonic() - begin:.0f} s")


def check_kept(plan: Plan) -> None:
    """Raise OSError, which names the files, unless every episode of the plan is kept."""
    total = len(plan.configurations) * len(plan.seeds)
    for dataset in filter(None, (plan.dataset, plan.trajectories)):
        missing = [*chain(*(dataset.missing(each, plan.seeds) for each in plan.configurations))]
        if missing:
            names = ", ".join(str(file.relative_to(dataset.folder)) for file in missing[:NAMED])
            more = f" and {len(missing) - NAMED} more" if len(missing) > NAMED else ""
            raise OSError(
                f"{dataset.name}: {len(missing)} of {total} episodes no longer exist:"
                f" {names}{more}; the results above count them, and the same command runs them"
                " again where it needs them"
            )
