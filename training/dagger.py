"""DAgger for the confidence weighting: supervised learning from the true errors of estimates.

In training, and nowhere else, the true error of a robot's own estimate of an area and that of the
estimate it hears are known, so a weight can be scored without trial and error. The exchanges that
robots meet depend on how they weigh. Therefore in each round robots run new worlds under the
current network, all their exchanges are recorded, and the network is fitted to minimise the error
of the merged estimates.

Source: Ross2011, A Reduction of Imitation Learning and Structured Prediction to No-Regret
Online Learning (DAgger); here without data of earlier
rounds, and with a falling learning rate.
"""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np
import torch
from joblib import delayed
from torch import Tensor

from baselines.controller import LayeredController
from baselines.oracles.oracle import errors
from baselines.running import RunningLayers
from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.foraging.array_rules import ArrayWeighting
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.foraging.views import WeightingInput
from swarm_forage_env.foraging.world import ForagingWorld
from swarm_forage_env.loop import Loop
from swarm_forage_env.spaces import ObservationLayout, ObservationWriter
from training.actor_critic import WeightingActor
from training.candidate_rollouts import CandidateRollouts, run_parallel
from training.checkpoint import (
    BEST_POLICY,
    CHECKPOINT,
    evaluation_point,
    policy_card,
    read_checkpoint,
    write_checkpoint,
)
from training.experiment import Experiment, worlds_per_scenario
from training.learned_weighting import flatten, network_weighting, weighting_network_shapes
from training.policy_file import (
    Card,
    CurvePoint,
    Policy,
    layer_card,
    observation_layout,
    save_policy,
)
from training.progress import ProgressLogger
from training.training_loop import run

HIDDEN = 16
"""Hidden units: supervised learning can fit more of them than a search."""

MAX_SQUARED_ERROR = 0.5
"""Upper bound of the squared error in the loss [m2]: a robot with an error of 0.7 m is lost."""

GRADIENT_STEPS, BATCH_SIZE, LEARNING_RATE = 500, 1024, 0.01
"""Of Adam: steps in a round, exchanges of each scenario in a step, and initial learning rate,
which falls linearly to zero over the budget."""


def squared_error(g: Tensor, own: Tensor, heard: Tensor) -> Tensor:
    """Squared error of the merged estimate, at most `MAX_SQUARED_ERROR` [m2].

        |(1 - g) e_i + g e_j|^2

    e_i, e_j are the true errors of the own and of the heard estimate of the area [m].
    """
    merged = (1.0 - g)[:, None] * own + g[:, None] * heard
    return torch.clamp((merged**2).sum(1), max=MAX_SQUARED_ERROR)


def oracle_gain(own: Tensor, heard: Tensor) -> Tensor:
    """Mean reduction of the squared error by an oracle, which takes the better estimate [m2]."""
    nobody = torch.zeros(len(own))
    alone, told = squared_error(nobody, own, heard), squared_error(nobody + 1.0, own, heard)
    return (alone - torch.minimum(alone, told)).mean()


@dataclass(frozen=True)
class Exchanges:
    """Recorded exchanges of two estimates of one area, a row for each such area."""

    observed: Float32[Array, "rows numbers"]
    """Observation of the exchange."""
    area: Float32[Array, "rows areas"]
    """One-hot vector of the area."""
    own_error: Float32[Array, "rows 2"]
    """True error of the robot's own estimate of the area [m]."""
    heard_error: Float32[Array, "rows 2"]
    """True error of the estimate that it heard [m]."""

    def __len__(self) -> int:
        """Number of rows."""
        return len(self.observed)

    @classmethod
    def of(cls, parts: Sequence["Exchanges"], n_features: int) -> "Exchanges":
        """Join exchanges whose observations have so many features."""
        nothing = [np.zeros((0, width), np.float32) for width in (n_features, 2, 2, 2)]
        columns = zip(nothing, *(each._columns for each in parts), strict=True)
        return cls(*(np.concatenate(each) for each in columns))

    def draw(self, draws: torch.Generator) -> "Exchanges":
        """Draw a batch with replacement."""
        rows = torch.randint(len(self), (BATCH_SIZE,), generator=draws).numpy()
        return Exchanges(*(each[rows] for each in self._columns))

    def error(self, actor: WeightingActor) -> Tensor:
        """Mean squared error of the estimates that a network merges [m2]."""
        weights, _ = actor(torch.from_numpy(self.observed))
        g = (weights * torch.from_numpy(self.area)).sum(1)
        return squared_error(g, *self._errors).mean()

    def gain(self, name: str) -> Tensor:
        """Error reduction by an oracle, `oracle_gain`; ConfigError, with `name`, if it is zero."""
        if not len(self) or not (gain := oracle_gain(*self._errors)) > 0.0:
            raise ConfigError(
                f"scenario '{name}': in {len(self)} exchanges nobody who knew an area was told"
                " a better place of it, so that there is nothing to learn; take more --worlds, or"
                " worlds in which robots meet"
            )
        return gain

    def share(self, actor: WeightingActor, gain: Tensor) -> float:
        """Error reduction by a network, as a share of the error reduction by the oracle."""
        nobody = squared_error(torch.zeros(len(self)), *self._errors).mean()
        with torch.no_grad():
            return float((nobody - self.error(actor)) / gain)

    @property
    def _columns(self) -> tuple[Array, Array, Array, Array]:
        return self.observed, self.area, self.own_error, self.heard_error

    @property
    def _errors(self) -> tuple[Tensor, Tensor]:
        return torch.from_numpy(self.own_error), torch.from_numpy(self.heard_error)


@dataclass(frozen=True)
class RecordingWeighting:
    """A weighting by a network that records all exchanges with their true errors."""

    numbers: Float32[Array, " numbers"]
    """Flat weights of the network."""
    layout: ObservationLayout
    """Layout of the observations that are recorded."""
    recorded: list[Exchanges] = field(default_factory=list)
    """The exchanges so far, in the order of the ticks in which they ended."""

    heard_p_share: ClassVar[float] = 1.0

    def start_knowing(self, running: RunningLayers, world: ForagingWorld) -> "ExchangeRecorder":
        """Start the running weighting, with access to the beliefs and to the ground truth."""
        return ExchangeRecorder(self, running, world)


class ExchangeRecorder:
    """The running weighting of a `RecordingWeighting`."""

    def __init__(
        self, weighting: RecordingWeighting, running: RunningLayers, world: ForagingWorld
    ) -> None:
        """Take the beliefs of the robots of a running controller, and their world."""
        self._weigh = ArrayWeighting(network_weighting(weighting.numbers))
        self._writer = ObservationWriter(weighting.layout, world.rows)
        self._recorded = weighting.recorded
        self._is_double = running.estimator.numbers["double"] > 0.0
        self._minds, self._world = running.minds, world

    def __call__(self, exchange: WeightingInput) -> Float32[Array, "rows areas"]:
        """Record the exchanges that end in this tick, and return g for each row and area."""
        met = exchange.own_known & exchange.heard_known
        if not self._is_double:
            met &= exchange.goal[:, None] == np.arange(2)
        row, area = np.nonzero(met)
        own, heard = errors(self._minds, self._world)
        observed = self._writer.write({"encounter": exchange})[row]
        columns = observed, np.eye(2)[area], own[row, area], heard[row, area]
        self._recorded.append(Exchanges(*(each.astype(np.float32) for each in columns)))
        return self._weigh(exchange)


def record_exchanges(
    scenario: Scenario,
    controller: LayeredController,
    numbers: Float32[Array, " numbers"],
    seeds: Sequence[int],
    physics: str,
) -> Exchanges:
    """Run whole episodes under a network, and return all exchanges with their true errors."""
    weighting = RecordingWeighting(numbers, observation_layout("weighting", scenario))
    loop = Loop(scenario, replace(controller, weighting=weighting), seeds, physics)
    for _ in range(scenario.n_ticks):
        loop.step()
    return Exchanges.of(weighting.recorded, len(weighting.layout))


def initial_actor(experiment: Experiment) -> WeightingActor:
    """The network to train: the controller's own if it is a learned one, else a new one."""
    layout = observation_layout("weighting", next(iter(experiment.scenarios_by_name.values())))
    policy = experiment.policy_of("weighting")
    if policy is None:
        return WeightingActor(layout, HIDDEN)
    sizes = policy.card.layers["weighting"].sizes
    actor = WeightingActor(layout, sizes["hidden"])
    weights = policy.weights_of("weighting", weighting_network_shapes(sizes))
    actor.load_numpy(weights)
    return actor


def train(experiment: Experiment, say: Callable[[str], None]) -> Policy:
    """Run or resume an experiment with DAgger, and return the best policy."""
    return run(DAggerTraining(experiment), experiment, "round", say)


class DAggerTraining:
    """A resumable DAgger training."""

    def __init__(self, experiment: Experiment) -> None:
        """Start a training, or resume it from the checkpoint in the experiment's folder."""
        self._experiment = experiment
        self._scenarios = experiment.scenarios_by_name
        self._n_worlds = worlds_per_scenario(experiment)
        self._rollouts = CandidateRollouts(
            self._scenarios, experiment.base_controller, experiment.physics, experiment.workers
        )
        torch.manual_seed(experiment.seed)
        self._actor = initial_actor(experiment)
        self._file = experiment.out / CHECKPOINT
        self._best = self._actor.to_numpy()
        self.done = 0
        self.curve: list[CurvePoint] = []
        if self._file.exists():
            self._read()
        else:
            self._save()
        self._rollouts.warm_up(self._numbers)

    def advance(self, progress: ProgressLogger) -> str:
        """Run one round (record, fit), save the checkpoint, and return a line on the gain."""
        begin = time.perf_counter()
        found = self._exchanges()
        wall = time.perf_counter() - begin
        shares = self._fit(found)
        self.done += 1
        self._save()
        numbers = {f"share/{name}": share for name, share in shares.items()}
        numbers["speed/episodes_per_s"] = sum(self._n_worlds.values()) / wall
        numbers["speed/simulated_s_per_s"] = self._simulated_s / self.done / wall
        progress.log_scalars(self.done, numbers)
        told = ", ".join(f"{name} {share:.0%}" for name, share in shares.items())
        return f"round {self.done}: of what an oracle gains at an exchange, {told}"

    def evaluate(self) -> CurvePoint:
        """Evaluate the network on the held-back seeds, and save it if it is the best."""
        seeds = self._experiment.held_back_seeds
        found = self._rollouts.round_trips(self._numbers[None], seeds)
        trips = {name: each[0] for name, each in found.items()}
        point = evaluation_point(self.done, self._simulated_s, trips)
        if all(point.value > each.value for each in self.curve):
            self._best = self._actor.to_numpy()
        self.curve.append(point)
        self._save()
        self.save_best()
        return point

    def save_best(self) -> None:
        """Write the best policy so far, with the learning curve on its card."""
        best = max(self.curve, key=lambda point: point.value)
        weights = {f"weighting.{name}": array for name, array in self._best.items()}
        save_policy(self._experiment.out / BEST_POLICY, weights, self._card(best))

    def _exchanges(self) -> dict[str, Exchanges]:
        """Record the exchanges of one round of new worlds, for each scenario."""
        experiment = self._experiment
        seeds = experiment.training_seeds(self.done * experiment.worlds, experiment.worlds)
        calls = (
            delayed(record_exchanges)(
                scenario,
                experiment.base_controller,
                self._numbers,
                seeds[: self._n_worlds[name]],
                experiment.physics,
            )
            for name, scenario in self._scenarios.items()
        )
        found = run_parallel(calls, experiment.workers)
        return dict(zip(self._scenarios, found, strict=True))

    def _fit(self, found: Mapping[str, Exchanges]) -> dict[str, float]:
        """Fit the network; return its error reduction as a share of the oracle's, per scenario."""
        experiment = self._experiment
        torch.set_num_threads(1)  # so that sums are the same whatever the workers
        draws = torch.Generator().manual_seed(experiment.seed + self.done)
        gains = {name: each.gain(name) for name, each in found.items()}
        left = 1.0 - self.done / experiment.budget
        optimiser = torch.optim.Adam(self._actor.parameters(), LEARNING_RATE * left)
        for _ in range(GRADIENT_STEPS):
            errors = [each.draw(draws).error(self._actor) / gains[k] for k, each in found.items()]
            loss = torch.stack(errors).mean()
            optimiser.zero_grad()
            loss.backward()  # type: ignore[no-untyped-call]
            optimiser.step()
        return {name: each.share(self._actor, gains[name]) for name, each in found.items()}

    @property
    def _numbers(self) -> Float32[Array, " numbers"]:
        """Flat weights of the current network."""
        shapes = weighting_network_shapes(self._actor.sizes)
        return flatten(self._actor.to_numpy(), shapes).astype(np.float32)

    @property
    def _simulated_s(self) -> float:
        """Simulated time of all rounds so far, summed over worlds [s]."""
        each = (self._n_worlds[k] * s.n_ticks * s.tick for k, s in self._scenarios.items())
        return self.done * sum(each)

    def _save(self) -> None:
        best = {f"best.{name}": array for name, array in self._best.items()}
        arrays = {"rounds": np.array(self.done), **self._actor.to_numpy(), **best}
        write_checkpoint(self._file, self._experiment.identity, self.curve, arrays)

    def _read(self) -> None:
        now = {name: array.shape for name, array in self._actor.to_numpy().items()}
        wanted = {"rounds": (), **now, **{f"best.{name}": shape for name, shape in now.items()}}
        self.curve, arrays = read_checkpoint(self._file, self._experiment.identity, wanted)
        self.done = int(arrays["rounds"])
        self._actor.load_numpy({name: arrays[name] for name in now})
        self._best = {name: arrays[f"best.{name}"] for name in now}

    def _card(self, best: CurvePoint) -> Card:
        scenario, actor = next(iter(self._scenarios.values())), self._actor
        layer = layer_card("weighting", scenario, actor.network, actor.sizes)
        return policy_card(
            self._experiment, {"weighting": layer}, ("torch",), self.curve, best.round_trips
        )
