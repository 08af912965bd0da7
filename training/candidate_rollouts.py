"""Rollouts of candidate policies: round trips of many networks in many worlds, in parallel.

Worlds run in batches: many parallel ones on a CPU, all of a scenario on a GPU. The round trips of a
candidate do not depend on its batch.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from baselines.controller import LayeredController
from baselines.evaluation.backends import Backend, JoblibBackend, run_in_order
from baselines.evaluation.episode import compile_episodes, run_episodes
from swarm_forage_env.arrays import Array, Float32, Int64
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.interface import MotionLayer, WeightingLayer
from training.learned_weighting import EXCHANGE_NETWORK, WeightingNetwork
from training.linear_motion_policy import LinearMotion

Architecture = WeightingNetwork | LinearMotion

MAX_ROWS = 2000
"""Approximate number of robots in one job; larger batches hardly reduce the overhead per robot."""


@dataclass(frozen=True)
class Candidate:
    """Candidate for a layer: a network, given by its flat weights."""

    weights: Float32[Array, " numbers"]
    architecture: Architecture = EXCHANGE_NETWORK

    def layer(self, scenario: Scenario) -> WeightingLayer | MotionLayer:
        """Return the network as a compiled layer."""
        return self.architecture.layer(self.weights, scenario)


@dataclass(frozen=True)
class RolloutJob:
    """A batch of worlds of one scenario, each with its candidate, run by one worker process."""

    scenario: Scenario
    controllers: tuple[LayeredController, ...]
    """Controller of each world: its candidate and the layers that all share."""
    seeds: tuple[int, ...]  # seed of each world
    physics: str
    device: str


@dataclass(frozen=True)
class CandidateRollouts:
    """Evaluation of candidates by rollouts in given scenarios, with a controller's other layers."""

    scenarios: Mapping[str, Scenario]
    controller: LayeredController
    physics: str = "rigid"
    backend: Backend = JoblibBackend()  # noqa: RUF009 frozen
    architecture: Architecture = EXCHANGE_NETWORK
    """Architecture of the candidates; it determines the layer that they replace."""
    device: str = "cpu"  # where worlds run: "cpu" or "cuda"

    def warm_up(self, network: Float32[Array, " numbers"]) -> None:
        """Compile all kernels once. ConfigError for what does not run on the device."""
        for scenario in self.scenarios.values():
            compile_episodes(scenario, self._with(network), self.physics, self.device)

    def round_trips(
        self, networks: Float32[Array, "networks numbers"], seeds: Sequence[int]
    ) -> dict[str, Int64[Array, "networks worlds"]]:
        """Return the round trips of every candidate under every seed, for each scenario."""
        jobs = {
            name: list(self._jobs(scenario, networks, seeds))
            for name, scenario in self.scenarios.items()
        }
        queue = [job for each in jobs.values() for job in each]
        is_cpu = self.device == "cpu"
        trips = iter(run_in_order(self.backend, run_job, queue) if is_cpu else map(run_job, queue))
        shape = len(networks), len(seeds)
        return {
            name: np.concatenate([next(trips) for _ in each]).reshape(shape)
            for name, each in jobs.items()
        }

    def simulated_s(self, worlds: int) -> float:
        """Return the simulated time of `worlds` episodes of each scenario, summed [s]."""
        return worlds * sum(each.n_ticks * each.tick for each in self.scenarios.values())

    def _jobs(
        self, scenario: Scenario, networks: Float32[Array, "networks numbers"], seeds: Sequence[int]
    ) -> Iterator[RolloutJob]:
        candidates = [self._with(network) for network in networks]
        worlds = [(candidate, seed) for candidate in candidates for seed in seeds]
        size = len(worlds)
        if self.device == "cpu":
            block_size = max(1, MAX_ROWS // scenario.task.n_robots)
            size = min(block_size, math.ceil(len(worlds) / self.backend.workers))
        for part in np.array_split(np.arange(len(worlds)), math.ceil(len(worlds) / size)):
            controllers, own_seeds = zip(*(worlds[k] for k in part), strict=True)
            yield RolloutJob(scenario, controllers, own_seeds, self.physics, self.device)

    def _with(self, network: Float32[Array, " numbers"]) -> LayeredController:
        candidate = Candidate(network, self.architecture)
        if isinstance(self.architecture, LinearMotion):
            return replace(self.controller, motion=candidate)
        return replace(self.controller, weighting=candidate)


def run_job(job: RolloutJob) -> Int64[Array, " worlds"]:
    """Run the episodes of a job and return the round trips of each world."""
    terms = job.scenario, job.controllers, job.seeds, job.physics
    return np.array([each.round_trips for each in run_episodes(*terms, device=job.device)])
