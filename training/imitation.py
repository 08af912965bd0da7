"""A weighting that learns from the truth: from the places that robots were wrong about.

In training, and nowhere else, it is known by how much the own place errs at an exchange, and by
how much the heard one. So what a weight is worth need not be found out by trial. In each round
robots that weigh by the network itself run new worlds, for what they meet depends on how they
weigh; all their exchanges are noted, and the network is fitted to the weights that would have
made the merged places err least.

Source: Ross2011, A Reduction of Imitation Learning and Structured Prediction to No-Regret
Online Learning (DAgger); here without the exchanges of earlier rounds, with a falling rate.
"""

import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from typing import cast

import numpy as np
import torch
from joblib import Parallel, delayed
from torch import Tensor

from baselines.controller import Recipe
from baselines.estimators.social_odometry import SocialOdometry
from baselines.evaluation.runner import ignore_sigint
from baselines.references.oracle import errors
from baselines.references.reference import Reference
from swarm_forage_env.arrays import Array, Float32, Float64
from swarm_forage_env.envs.layout import ObservationLayout, Sheet
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.ground_truth import GroundTruth
from swarm_forage_env.interface import Encounter
from swarm_forage_env.loop import ControlLoop
from swarm_forage_env.scenario import Scenario
from training.actor_critic import WeightingTower
from training.checkpoint import (
    BEST,
    NAME,
    card_of,
    judged,
    read_checkpoint,
    write_checkpoint,
)
from training.course import run
from training.experiment import Experiment, worlds_of
from training.policy import (
    Card,
    CurvePoint,
    Policy,
    encounter_layout,
    layer_card,
    save_policy,
)
from training.telling import Teller
from training.trials import Trials
from training.weighting import Networks, shapes_of, strung

HIDDEN = 16
"""Hidden units: a fit bears more of them than a search."""

FAR = 0.5
"""A squared error counts at most this much [m2]: who misses an area by 0.7 m is lost anyway."""

STEPS, BATCH, RATE = 500, 1024, 0.01
"""Steps of Adam in a round, exchanges of each scenario in a step, learning rate in the first
round; it falls to zero over the budget."""


def squared_error(g: Tensor, own: Tensor, heard: Tensor) -> Tensor:
    """Squared error of the merged place, at most `FAR` [m2].

        |(1 - g) e_i + g e_j|^2

    e_i, e_j are the errors of the own and of the heard place [m].
    """
    merged = (1.0 - g)[:, None] * own + g[:, None] * heard
    return torch.clamp((merged**2).sum(1), max=FAR)


def oracle_gain(own: Tensor, heard: Tensor) -> Tensor:
    """What taking the truly nearer place gains over believing nobody [m2]: the mean."""
    nobody = torch.zeros(len(own))
    alone, told = squared_error(nobody, own, heard), squared_error(nobody + 1.0, own, heard)
    return (alone - torch.minimum(alone, told)).mean()


@dataclass(frozen=True)
class Exchanges:
    """Exchanges in which two places of one area met, a row for each such area."""

    observed: Float32[Array, "rows numbers"]
    """The robot's encounter, as an observation shows it."""
    area: Float32[Array, "rows areas"]
    """1 for the area in question."""
    own_error: Float32[Array, "rows 2"]
    """By how much the own place truly misses the area [m]."""
    heard_error: Float32[Array, "rows 2"]
    """By how much the heard place does [m]."""

    def __len__(self) -> int:
        """How many."""
        return len(self.observed)

    def draw(self, draws: torch.Generator) -> "Exchanges":
        """A batch of them, with replacement."""
        rows = torch.randint(len(self), (BATCH,), generator=draws).numpy()
        every = self.observed, self.area, self.own_error, self.heard_error
        return Exchanges(*(each[rows] for each in every))

    def error(self, tower: WeightingTower) -> Tensor:
        """Squared error of the places that a network merges [m2]: the mean."""
        weights, _ = tower(torch.from_numpy(self.observed))
        g = (weights * torch.from_numpy(self.area)).sum(1)
        return squared_error(g, *self._errors).mean()

    def gain(self, name: str) -> Tensor:
        """What an oracle gains in the scenario of this name; ConfigError if that is nothing."""
        if not len(self) or not (gain := oracle_gain(*self._errors)) > 0.0:
            raise ConfigError(
                f"scenario '{name}': in {len(self)} exchanges nobody who knew an area was told"
                " a better place of it, so that there is nothing to learn; take more --worlds, or"
                " worlds in which robots meet"
            )
        return gain

    def share(self, tower: WeightingTower, gain: Tensor) -> float:
        """What a network gains over believing nobody, as a share of what the oracle gains."""
        nobody = squared_error(torch.zeros(len(self)), *self._errors).mean()
        with torch.no_grad():
            return float((nobody - self.error(tower)) / gain)

    @property
    def _errors(self) -> tuple[Tensor, Tensor]:
        return torch.from_numpy(self.own_error), torch.from_numpy(self.heard_error)


@dataclass(frozen=True)
class Watched:
    """In the place of a weighting: a network, watched by one who knows the truth."""

    numbers: Float32[Array, " numbers"]
    layout: ObservationLayout

    def start_knowing(self, estimator: SocialOdometry, truth: GroundTruth) -> "Watch":
        """The running network of robots that believe this, in worlds of which that is true."""
        return Watch(self, estimator, truth)


class Watch:
    """Weighs as the network does, and notes every exchange."""

    heard_p_share = Networks.heard_p_share

    def __init__(self, watched: Watched, estimator: SocialOdometry, truth: GroundTruth) -> None:
        """Nothing noted yet."""
        self._weigh = Networks(watched.numbers[None])
        self._sheet = Sheet(watched.layout, len(truth.pose))
        self._n_slots = len(watched.layout)
        self._estimator = estimator
        self._truth = truth
        self._noted: list[tuple[Array, ...]] = []

    def __call__(self, encounter: Encounter) -> Float32[Array, "rows areas"]:
        """g for each row and area."""
        met = encounter.own_known & encounter.heard_known
        if not self._estimator.parameters.double:
            met &= encounter.goal[:, None] == np.arange(2)
        row, area = np.nonzero(met)
        own, heard = errors(self._estimator.beliefs, self._truth)
        observed = self._sheet.write({"encounter": encounter})[row]
        one: Float64[Array, "areas areas"] = np.eye(2)
        self._noted.append((observed, one[area], own[row, area], heard[row, area]))
        return self._weigh(encounter)

    @property
    def exchanges(self) -> Exchanges:
        """All that were noted."""
        nothing = np.zeros((0, self._n_slots)), np.zeros((0, 2)), np.zeros((0, 2)), np.zeros((0, 2))
        columns = zip(nothing, *self._noted, strict=True)
        return Exchanges(*(np.concatenate(each).astype(np.float32) for each in columns))


def watch(
    scenario: Scenario,
    recipe: Recipe,
    numbers: Float32[Array, " numbers"],
    seeds: Sequence[int],
    physics: str,
) -> Exchanges:
    """All exchanges of whole episodes of robots that weigh by a network."""
    watched = Watched(numbers, encounter_layout(scenario))
    privileged = Reference(recipe.name, recipe.estimator, watched, recipe.motion)
    loop = ControlLoop(scenario, privileged, seeds, physics)
    for _ in range(scenario.n_ticks):
        loop.step()
    return cast(Watch, loop.controller.weighting).exchanges


def tower_of(experiment: Experiment) -> WeightingTower:
    """The network to fit: the controller's own if that is a learned one, else a new one."""
    layout = encounter_layout(next(iter(experiment.worlds_by_name.values())))
    policy = experiment.policy_of("weighting")
    if policy is None:
        return WeightingTower(layout, HIDDEN)
    sizes = policy.card.layers["weighting"].sizes
    tower = WeightingTower(layout, sizes["hidden"])
    weights = policy.weights_of("weighting", shapes_of(sizes))
    tower.load_state_dict({name: torch.from_numpy(array) for name, array in weights.items()})
    return tower


def train(experiment: Experiment, say: Callable[[str], None]) -> Policy:
    """Run an experiment, or what is left of it, telling how it gets on; the best policy."""
    return run(Imitation(experiment), experiment, "round", say)


class Imitation:
    """A training under way; all that it depends on is in its checkpoint."""

    def __init__(self, experiment: Experiment) -> None:
        """Start, or go on from the checkpoint in the experiment's folder."""
        self._experiment = experiment
        self._scenarios = experiment.worlds_by_name
        self._n_worlds = worlds_of(experiment)
        self._trials = Trials(
            self._scenarios, experiment.recipe, experiment.physics, experiment.workers
        )
        torch.manual_seed(experiment.seed)
        self._tower = tower_of(experiment)
        self._file = experiment.out / NAME
        self._best = self._tower.as_in_file()
        self.done = 0
        self.curve: list[CurvePoint] = []
        if self._file.exists():
            self._read()
        else:
            self._keep()
        self._trials.warm_up()

    def advance(self, teller: Teller) -> str:
        """One round: meet, note, fit, and keep the checkpoint; what was gained, to be said."""
        begin = time.perf_counter()
        found = self._exchanges()
        wall = time.perf_counter() - begin
        shares = self._fit(found)
        self.done += 1
        self._keep()
        numbers = {f"share/{name}": share for name, share in shares.items()}
        numbers["speed/episodes_per_s"] = sum(self._n_worlds.values()) / wall
        numbers["speed/simulated_s_per_s"] = self._simulated_s / self.done / wall
        teller.scalars(self.done, numbers)
        told = ", ".join(f"{name} {share:.0%}" for name, share in shares.items())
        return f"round {self.done}: of what an oracle gains at an exchange, {told}"

    def evaluate(self) -> CurvePoint:
        """Judge the network on the held-back worlds, and keep it if it is the best."""
        seeds = self._experiment.held_back_seeds
        found = self._trials.round_trips(self._numbers[None], seeds)
        trips = {name: each[0] for name, each in found.items()}
        point = judged(self.done, self._simulated_s, trips)
        if all(point.value > each.value for each in self.curve):
            self._best = self._tower.as_in_file()
        self.curve.append(point)
        self._keep()
        self.keep_best()
        return point

    def keep_best(self) -> None:
        """Write the best policy so far, with the curve so far."""
        best = max(self.curve, key=lambda point: point.value)
        weights = {f"weighting.{name}": array for name, array in self._best.items()}
        save_policy(self._experiment.out / BEST, weights, self._card(best))

    def _exchanges(self) -> dict[str, Exchanges]:
        """Those of a round of new worlds, in each scenario."""
        experiment = self._experiment
        seeds = experiment.training_seeds(self.done * experiment.worlds, experiment.worlds)
        parallel = Parallel(n_jobs=experiment.workers, return_as="generator", batch_size=1)
        with ignore_sigint():
            finished = parallel(
                delayed(watch)(
                    scenario,
                    experiment.recipe,
                    self._numbers,
                    seeds[: self._n_worlds[name]],
                    experiment.physics,
                )
                for name, scenario in self._scenarios.items()
            )
        with closing(finished):  # ends the workers, whatever happens
            return dict(zip(self._scenarios, finished, strict=True))

    def _fit(self, found: Mapping[str, Exchanges]) -> dict[str, float]:
        """Fit the network; of what an oracle would gain, the share that it gains afterwards."""
        experiment = self._experiment
        torch.set_num_threads(1)  # so that sums are the same whatever the workers
        draws = torch.Generator().manual_seed(experiment.seed + self.done)
        gains = {name: each.gain(name) for name, each in found.items()}
        left = 1.0 - self.done / experiment.budget
        optimiser = torch.optim.Adam(self._tower.parameters(), RATE * left)
        for _ in range(STEPS):
            errors = [each.draw(draws).error(self._tower) / gains[k] for k, each in found.items()]
            loss = torch.stack(errors).mean()
            optimiser.zero_grad()
            loss.backward()  # type: ignore[no-untyped-call]
            optimiser.step()
        return {name: each.share(self._tower, gains[name]) for name, each in found.items()}

    @property
    def _numbers(self) -> Float32[Array, " numbers"]:
        """The network as it stands, in a row."""
        shapes = shapes_of(self._tower.sizes)
        return strung(self._tower.as_in_file(), shapes).astype(np.float32)

    @property
    def _simulated_s(self) -> float:
        """Simulated time of all rounds so far, summed over worlds [s]."""
        each = (self._n_worlds[k] * s.n_ticks * s.tick for k, s in self._scenarios.items())
        return self.done * sum(each)

    def _keep(self) -> None:
        best = {f"best.{name}": array for name, array in self._best.items()}
        arrays = {"rounds": np.array(self.done), **self._tower.as_in_file(), **best}
        write_checkpoint(self._file, self._experiment.identity, self.curve, arrays)

    def _read(self) -> None:
        now = tuple(self._tower.arrays)
        names = ("rounds", *now, *(f"best.{name}" for name in now))
        self.curve, arrays = read_checkpoint(self._file, self._experiment.identity, names)
        self.done = int(arrays["rounds"])
        self._tower.load_state_dict({name: torch.from_numpy(arrays[name]) for name in now})
        self._best = {name: arrays[f"best.{name}"] for name in now}

    def _card(self, best: CurvePoint) -> Card:
        scenario, tower = next(iter(self._scenarios.values())), self._tower
        layer = layer_card("weighting", scenario, tower.network, tower.sizes)
        return card_of(
            self._experiment, {"weighting": layer}, ("torch",), self.curve, best.round_trips
        )
