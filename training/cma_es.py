"""CMA-ES on a policy of few weights: direct maximisation of the swarm's round trips.

The search starts from the layer of the controller: from its weights if it is learned, else near the
hand-written rule. In each generation all candidates run in the same new worlds (common random
numbers). The policy saved is the search mean with the best score on the held-back seeds.

Source: Hansen2016, The CMA Evolution Strategy: A Tutorial (the package cmaes).
"""

import math
import time
from collections.abc import Callable, Mapping

import numpy as np
from cmaes import CMA

from baselines.evaluation.backends import Backend, JoblibBackend
from baselines.weighting.sgiff import SGIFF
from swarm_forage_env.arrays import Array, Float32, Float64, Int64
from training.candidate_rollouts import Architecture
from training.experiment import Experiment, step_seed
from training.learned_weighting import EXCHANGE_NETWORK, HIDDEN
from training.linear_motion_policy import LINEAR_MOTION
from training.policy_file import LayerName, Policy, load_policy
from training.training_loop import NetworkTraining, ProgressLogger, run

INITIAL_SIGMA: Mapping[LayerName, float] = {"weighting": 0.3, "motion": 0.05}
"""Initial step size: standard deviation of every weight in the first generation."""

INITIAL_BETA = 0.001
"""Beta of the SGIFF rule that the search starts from [1/cm]: the best one in large arenas."""

ARCHITECTURES: dict[str, Architecture] = {"weighting": EXCHANGE_NETWORK, "motion": LINEAR_MOTION}
"""Architecture whose weights are searched, for each layer."""

SIZES: Mapping[LayerName, Mapping[str, int]] = {"weighting": {"hidden": HIDDEN}, "motion": {}}
"""Sizes of the architecture of each layer, unless the search starts from a learned layer."""


def train(
    experiment: Experiment, say: Callable[[str], None], backend: Backend | None = None
) -> Policy:
    """Run or resume an experiment with CMA-ES, and return the best policy.

    Candidates run on the backend; without one, in worker processes of this machine.
    """
    return load_policy(run(CMAESTraining(experiment, backend), experiment, "generation", say))


class CMAESTraining(NetworkTraining):
    """A resumable CMA-ES search.

    A checkpoint contains all candidates and losses, not the state of the search: passing them to a
    new search restores its state bit for bit.
    """

    packages = ("cmaes",)

    def __init__(self, experiment: Experiment, backend: Backend | None = None) -> None:
        (layer,) = experiment.layers
        sizes, start = initial_network(experiment, layer)
        backend = backend or JoblibBackend(experiment.workers)
        super().__init__(experiment, ARCHITECTURES[layer], sizes, backend)
        sigma = INITIAL_SIGMA[layer]
        self._search = CMA(start, sigma, population_size=experiment.population)
        self._candidates = self._search.population_size
        self._populations = np.zeros((0, self._candidates, len(start)), np.float32)
        self._losses = np.zeros((0, self._candidates), np.float64)
        self._open()
        self._rollouts.warm_up(self._search.mean)

    @property
    def done(self) -> int:
        """Generations completed so far."""
        return len(self._losses)

    def advance(self, progress: ProgressLogger) -> None:
        """Run one generation (ask, roll out, tell) and save the checkpoint."""
        experiment, begin = self._experiment, time.perf_counter()
        self._search.reseed_rng(step_seed(experiment.seed, self.done))
        population = np.array([self._search.ask() for _ in range(self._candidates)], np.float32)
        seeds = experiment.training_seeds(self.done * experiment.worlds, experiment.worlds)
        values = fitness_of(self._rollouts.round_trips(population, seeds))
        self._tell(population, -values)
        self._populations = np.concatenate([self._populations, population[None]])
        self._losses = np.concatenate([self._losses, -values[None]])
        self._save()
        worlds, wall = experiment.worlds * len(population), time.perf_counter() - begin
        progress.log_scalars(
            self.done,
            {
                "generation/value": float(values.mean()),
                "generation/best": float(values.max()),
                "generation/spread": float(population.std(axis=0).mean()),
                "speed/episodes_per_s": worlds * len(self._rollouts.scenarios) / wall,
                "speed/simulated_s_per_s": self._rollouts.simulated_s(worlds) / wall,
            },
        )

    @property
    def _numbers(self) -> Float32[Array, " numbers"]:
        return np.asarray(self._search.mean, np.float32)

    @property
    def _simulated_s(self) -> float:
        worlds = self.done * self._experiment.worlds * self._candidates
        return self._rollouts.simulated_s(worlds)

    @property
    def _state(self) -> dict[str, Array]:
        return {"populations": self._populations, "losses": self._losses}

    def _restore(self, arrays: Mapping[str, Array]) -> None:
        self._populations, self._losses = arrays["populations"], arrays["losses"]
        for population, losses in zip(self._populations, self._losses, strict=True):
            self._tell(population, losses)

    def _tell(self, population: Float32[Array, "n numbers"], losses: Float64[Array, " n"]) -> None:
        self._search.tell(list(zip(population.astype(np.float64), losses.tolist(), strict=True)))


def initial_network(
    experiment: Experiment, layer: LayerName
) -> tuple[Mapping[str, int], Float64[Array, " numbers"]]:
    """Return sizes and flat weights of the network that the search starts from."""
    policy = experiment.policy_of(layer)
    if policy is None:
        return SIZES[layer], initial_mean(experiment.seed, layer)
    return policy.card.layers[layer].sizes, ARCHITECTURES[layer].numbers_of(policy)


def initial_mean(seed: int, layer: LayerName) -> Float64[Array, " numbers"]:
    """Return the weights that reproduce a hand-written rule, the initial search mean.

    Motion: zeros, which give subsumption. Weighting: SGIFF with a tenth of its default beta; the
    hidden units have random input weights, and output weights of zero.
    """
    shapes = ARCHITECTURES[layer].shapes(SIZES[layer])
    mean = np.zeros(sum(math.prod(shape) for shape in shapes.values()))
    if layer == "motion":
        return mean
    hidden = math.prod(shapes["hidden.weight"])
    spread = 1.0 / math.sqrt(shapes["hidden.weight"][1])
    mean[:hidden] = np.random.default_rng(seed).normal(0.0, spread, hidden)
    mean[-2] = INITIAL_BETA / SGIFF().beta - 1.0
    return mean


def fitness_of(trips: Mapping[str, Int64[Array, "networks worlds"]]) -> Float64[Array, " networks"]:
    """Return the fitness of each candidate: ln(1 + mean round trips), averaged over scenarios."""
    means = [np.log1p(each.mean(axis=1)) for each in trips.values()]
    return np.asarray(np.mean(means, axis=0), np.float64)
