"""CMA-ES on a policy of few weights: direct maximisation of the swarm's round trips.

The search starts at the controller's own layer: at its weights if it is a learned one, else near
the hand-written rule. In each generation all candidates run in the same new worlds (common random
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
from training.candidate_rollouts import CandidateRollouts
from training.checkpoint import BEST_POLICY, Checkpoint, evaluation_point, policy_card
from training.experiment import Experiment, step_seed
from training.learned_weighting import (
    HIDDEN,
    NETWORK,
    network_of,
    unflatten,
    weighting_network_shapes,
)
from training.linear_motion_policy import NETWORK as LINEAR
from training.linear_motion_policy import SHAPES as LINEAR_SHAPES
from training.linear_motion_policy import linear_policy_of
from training.policy_file import (
    Card,
    CurvePoint,
    LayerName,
    Policy,
    Shapes,
    layer_card,
    save_policy,
)
from training.training_loop import ProgressLogger, run

INITIAL_SIGMA: Mapping[LayerName, float] = {"weighting": 0.3, "motion": 0.05}
"""Initial step size: standard deviation of every weight in the first generation."""

INITIAL_BETA = 0.001
"""Beta of the SGIFF rule that the search starts from [1/cm]: the best one in large arenas."""

NETWORKS: Mapping[LayerName, str] = {"weighting": NETWORK, "motion": LINEAR}
"""Architecture that is searched for each layer, by its name on a card."""

SIZES: Mapping[LayerName, Mapping[str, int]] = {"weighting": {"hidden": HIDDEN}, "motion": {}}
"""Sizes of that architecture, unless the search starts from a learned layer."""


def train(
    experiment: Experiment, say: Callable[[str], None], backend: Backend | None = None
) -> Policy:
    """Run or resume an experiment with CMA-ES, and return the best policy.

    Candidates run on the backend; without one, in worker processes of this machine.
    """
    return run(CMAESTraining(experiment, backend), experiment, "generation", say)


class CMAESTraining:
    """A resumable CMA-ES search."""

    def __init__(self, experiment: Experiment, backend: Backend | None = None) -> None:
        """Start a search, or resume it from the checkpoint in the experiment's folder."""
        self._experiment = experiment
        (self._layer,) = experiment.layers
        self._sizes, start = initial_network(experiment, self._layer)
        self._shapes = network_shapes(self._layer, self._sizes)
        self._rollouts = CandidateRollouts(
            experiment.scenarios_by_name,
            experiment.base_controller,
            experiment.physics,
            backend or JoblibBackend(experiment.workers),
            self._layer,
            device=experiment.device,
        )
        sigma = INITIAL_SIGMA[self._layer]
        self._search = CMA(start, sigma, population_size=experiment.population)
        self._checkpoint = Checkpoint.open(experiment, self._search.population_size, len(start))
        for population, losses in self._checkpoint.generations():
            self._tell(population, losses)
        self._rollouts.warm_up(self._search.mean)

    @property
    def done(self) -> int:
        """Generations completed so far."""
        return self._checkpoint.n_generations

    @property
    def curve(self) -> list[CurvePoint]:
        """Learning curve so far: evaluations on the held-back seeds."""
        return self._checkpoint.curve

    def advance(self, progress: ProgressLogger) -> None:
        """Run one generation (ask, roll out, tell) and save the checkpoint."""
        experiment, begin = self._experiment, time.perf_counter()
        self._search.reseed_rng(step_seed(experiment.seed, self.done))
        asked = [self._search.ask() for _ in range(self._search.population_size)]
        population = np.array(asked, np.float32)
        seeds = experiment.training_seeds(self.done * experiment.worlds, experiment.worlds)
        values = fitness_of(self._rollouts.round_trips(population, seeds))
        self._tell(population, -values)
        self._checkpoint.add(population, -values)
        self._checkpoint.save()
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

    def evaluate(self) -> CurvePoint:
        """Evaluate the search mean on the held-back seeds, and save it if it is the best."""
        experiment = self._experiment
        mean = self._search.mean.astype(np.float32)
        found = self._rollouts.round_trips(mean[None], experiment.held_back_seeds)
        trained = self._rollouts.simulated_s(self.done * experiment.worlds * self._candidates)
        point = evaluation_point(
            self.done, trained, {name: each[0] for name, each in found.items()}
        )
        self._checkpoint.add_point(point, mean)
        self._checkpoint.save()
        self.save_best()
        return point

    def save_best(self) -> None:
        """Write the best policy so far, with the learning curve on its card."""
        best, numbers = self._checkpoint.best
        arrays = unflatten(numbers, self._shapes)
        weights = {f"{self._layer}.{name}": array for name, array in arrays.items()}
        save_policy(self._experiment.out / BEST_POLICY, weights, self._card(best))

    @property
    def _candidates(self) -> int:
        return int(self._search.population_size)

    def _tell(self, population: Float32[Array, "n numbers"], losses: Float64[Array, " n"]) -> None:
        told = zip(population.astype(np.float64), losses.tolist(), strict=True)
        self._search.tell(list(told))

    def _card(self, best: CurvePoint) -> Card:
        scenario = next(iter(self._rollouts.scenarios.values()))
        layer = layer_card(self._layer, scenario, NETWORKS[self._layer], self._sizes)
        layers = {self._layer: layer}
        return policy_card(self._experiment, layers, ("cmaes",), self.curve, best.round_trips)


def initial_network(
    experiment: Experiment, layer: LayerName
) -> tuple[Mapping[str, int], Float64[Array, " numbers"]]:
    """Sizes and flat weights of the network that the search starts from."""
    policy = experiment.policy_of(layer)
    if policy is None:
        return SIZES[layer], initial_mean(experiment.seed, layer)
    numbers = linear_policy_of(policy) if layer == "motion" else network_of(policy)
    return policy.card.layers[layer].sizes, numbers


def network_shapes(layer: LayerName, sizes: Mapping[str, int]) -> Shapes:
    """Shapes of the arrays of the network that is searched for a layer."""
    return LINEAR_SHAPES if layer == "motion" else weighting_network_shapes(sizes)


def initial_mean(seed: int, layer: LayerName) -> Float64[Array, " numbers"]:
    """Initial search mean without a learned layer: the weights that equal a hand-written rule.

    Motion: zeros, which is subsumption. Weighting: SGIFF with a tenth of its default beta; the
    hidden units have random input weights, and output weights of zero.
    """
    shapes = network_shapes(layer, SIZES[layer])
    mean = np.zeros(sum(math.prod(shape) for shape in shapes.values()))
    if layer == "motion":
        return mean
    hidden = math.prod(shapes["hidden.weight"])
    spread = 1.0 / math.sqrt(shapes["hidden.weight"][1])
    mean[:hidden] = np.random.default_rng(seed).normal(0.0, spread, hidden)
    mean[-2] = INITIAL_BETA / SGIFF().beta - 1.0
    return mean


def fitness_of(trips: Mapping[str, Int64[Array, "networks worlds"]]) -> Float64[Array, " networks"]:
    """Fitness of each candidate: ln(1 + mean round trips), averaged over the scenarios."""
    means = [np.log1p(each.mean(axis=1)) for each in trips.values()]
    return np.asarray(np.mean(means, axis=0), np.float64)
