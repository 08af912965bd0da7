"""Rollouts of candidate policies: round trips of many networks in many worlds, in parallel.

Worlds run in batches. A candidate has the same round trips in a batch as alone.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from typing import Any

import numpy as np
from joblib import Parallel, delayed

from baselines.controller import Recipe
from baselines.evaluation.experiment_config import ExperimentConfig
from baselines.evaluation.runner import ignore_sigint, warm_up
from swarm_forage_env.arrays import Array, Float32, Int64
from swarm_forage_env.loop import ControlLoop
from swarm_forage_env.metrics import total
from swarm_forage_env.scenario import Scenario
from training.learned_weighting import NetworkWeighting
from training.linear_motion_policy import LinearMotionPolicy
from training.policy_file import LayerName

MAX_ROWS = 2000
"""Robots in one job, about; larger batches hardly reduce the overhead per robot any further."""


@dataclass(frozen=True)
class RolloutJob:
    """A batch of worlds of one scenario, each with its candidate, run by one worker process."""

    scenario: Scenario
    recipe: Recipe
    physics: str
    networks: Float32[Array, "networks numbers"]
    which: tuple[int, ...]
    """Index of the candidate in each world."""
    seeds: tuple[int, ...]
    """Seed of each world."""
    layer: LayerName
    """Layer of the controller that the candidates replace."""


@dataclass(frozen=True)
class CandidateRollouts:
    """Evaluates candidates by rollouts in given scenarios, with the controller's other layers."""

    scenarios: Mapping[str, Scenario]
    recipe: Recipe
    physics: str = "rigid"
    workers: int = 1
    layer: LayerName = "weighting"

    def warm_up(self) -> None:
        """Compile every kernel once, so that worker processes find them in the cache."""
        for name, scenario in self.scenarios.items():
            warm_up(ExperimentConfig(name, scenario, self.recipe, self.physics))

    def round_trips(
        self, networks: Float32[Array, "networks numbers"], seeds: Sequence[int]
    ) -> dict[str, Int64[Array, "networks worlds"]]:
        """Round trips of every candidate under every seed, for each scenario."""
        jobs = {
            name: list(self._jobs(scenario, networks, seeds))
            for name, scenario in self.scenarios.items()
        }
        trips = iter(self._run([job for each in jobs.values() for job in each]))
        shape = len(networks), len(seeds)
        return {
            name: np.concatenate([next(trips) for _ in each]).reshape(shape)
            for name, each in jobs.items()
        }

    def simulated_s(self, worlds: int) -> float:
        """Simulated time of `worlds` episodes of each scenario, summed [s]."""
        return worlds * sum(each.n_ticks * each.tick for each in self.scenarios.values())

    def _jobs(
        self, scenario: Scenario, networks: Float32[Array, "networks numbers"], seeds: Sequence[int]
    ) -> Iterator[RolloutJob]:
        worlds = [(which, seed) for which in range(len(networks)) for seed in seeds]
        room = max(1, MAX_ROWS // scenario.task.n_robots)
        size = min(room, -(-len(worlds) // self.workers))
        for part in np.array_split(np.arange(len(worlds)), -(-len(worlds) // size)):
            which, own_seeds = zip(*(worlds[k] for k in part), strict=True)
            yield RolloutJob(
                scenario, self.recipe, self.physics, networks, which, own_seeds, self.layer
            )

    def _run(self, jobs: Sequence[RolloutJob]) -> list[Int64[Array, " worlds"]]:
        return run_parallel((delayed(run_job)(job) for job in jobs), self.workers)


def run_parallel(calls: Iterable[Any], workers: int) -> list[Any]:
    """Run joblib's delayed calls in worker processes, and return their results in order."""
    parallel = Parallel(n_jobs=workers, return_as="generator", batch_size=1)
    with ignore_sigint():
        finished = parallel(calls)
    with closing(finished):  # ends the workers, whatever happens
        return list(finished)


def run_job(job: RolloutJob) -> Int64[Array, " worlds"]:
    """Run the episodes of a job and return the round trips of each world."""
    loop = ControlLoop(job.scenario, job.recipe, job.seeds, job.physics)
    of_row = np.repeat(np.array(job.which, np.int64), job.scenario.task.n_robots)
    if job.layer == "weighting":
        loop.controller.weighting = NetworkWeighting(job.networks, of_row)
    else:
        loop.controller.motion = LinearMotionPolicy(job.networks, job.scenario, job.seeds, of_row)
    for _ in range(job.scenario.n_ticks):
        loop.step()
    return total(loop.world.state.round_trips, len(job.seeds))
