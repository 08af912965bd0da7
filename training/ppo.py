"""PPO on the learned layers: one policy for all robots, judged on held-back worlds.

Training goes in intervals. Each starts new worlds from seeds of its own and ends with an
evaluation and a checkpoint, so that a run that was stopped goes on from the last interval and
ends where it would have ended. The first interval of a motion trains the critic alone: the
motion starts as a copy of the controller's own, which an untrained critic would undo.

Source: Schulman2017, Proximal Policy Optimization Algorithms (stable-baselines3).
"""

import math
import time
from collections.abc import Callable
from typing import cast

import numpy as np
import torch
from stable_baselines3.common.utils import FloatSchedule, set_random_seed

from baselines.evaluation.episode import run_episodes
from swarm_forage_env.arrays import Array, Float32, Int64
from swarm_forage_env.loop import ControlLoop
from training.actor_critic import MotionTower, Tower, Towers
from training.behaviour_cloning import clone, demonstrations
from training.checkpoint import (
    BEST,
    NAME,
    card_of,
    judged,
    not_writable,
    read_checkpoint,
    write_checkpoint,
)
from training.controllers import learned
from training.experiment import Experiment, worlds_of
from training.policy_file import (
    Card,
    CurvePoint,
    Interval,
    LayerName,
    Policy,
    layer_card,
    save_policy,
)
from training.progress import Teller
from training.sb3_setup import METHODS, environments, learner, restore, state_of
from training.training_loop import run

LATEST = "latest.safetensors"
"""The policy of the last interval."""

DEMONSTRATORS = 80
"""Robots of each scenario that are copied, about."""


def train(experiment: Experiment, say: Callable[[str], None]) -> Policy:
    """Run an experiment, or what is left of it, telling how it gets on; the best policy."""
    learning = Learning(experiment)
    if not learning.curve:
        say(learning.begin())
    return run(learning, experiment, "robot step", say)


class Learning:
    """A run under way; all that it depends on is in its checkpoint."""

    def __init__(self, experiment: Experiment) -> None:
        """Start, or go on from the checkpoint in the experiment's folder."""
        self._experiment = experiment
        torch.set_num_threads(experiment.workers)
        self._method = METHODS[experiment.layer]
        self._env = environments(experiment, self._method)
        try:
            self._model = learner(self._env, experiment, self._method)
        except OSError as error:  # of the logs, which come first
            raise not_writable(experiment.out, error) from None
        self._file = experiment.out / NAME
        self.curve: list[CurvePoint] = []
        self._best = self._weights
        if self._file.exists():
            names = [*state_of(self._model), *(f"best.{name}" for name in self._best)]
            self.curve, arrays = read_checkpoint(self._file, experiment.identity, names)
            restore(self._model, arrays)
            self._best = {name: arrays[f"best.{name}"] for name in self._best}

    @property
    def done(self) -> int:
        """Control ticks of single robots so far."""
        return int(self._model.num_timesteps) * self._method.decision_period

    def begin(self) -> str:
        """Copy the controller's own motion, if motion is learned; what is to be said of it."""
        tower, experiment = self._actors.get("motion"), self._experiment
        if not isinstance(tower, MotionTower):
            return "starting from nothing"
        set_random_seed(experiment.seed)
        pairs = []
        for scenario in experiment.worlds_by_name.values():
            n_worlds = max(1, DEMONSTRATORS // scenario.task.n_robots)
            seeds = experiment.training_seeds(0, n_worlds)
            loop = ControlLoop(scenario, experiment.recipe, seeds, experiment.physics)
            pairs.append(demonstrations(loop, self._env.observation_layout))
        error = clone(tower, pairs)
        return f"the motion of {experiment.controller} is copied; mean squared error {error:.3f}"

    def advance(self, teller: Teller) -> str:
        """One interval of training, in new worlds; its speed, to be said."""
        experiment, model, before = self._experiment, self._model, self.done
        begin, stepping = time.perf_counter(), self._env.stepping_s
        seed = _seed(experiment.seed, len(self.curve))
        set_random_seed(seed)
        self._env.seed(seed)
        model._last_obs = None  # so that learning starts with a reset
        left = max(0.0, 1.0 - before / experiment.budget)
        model.lr_schedule = FloatSchedule(self._method.rate * left)
        self._let_act(learn=len(self.curve) > 1 or "motion" not in self._actors)
        decisions = math.ceil(experiment.every / self._method.decision_period)
        model.learn(decisions, reset_num_timesteps=False)
        wall = time.perf_counter() - begin
        speed = (self.done - before) / wall
        share = (self._env.stepping_s - stepping) / wall
        numbers = {"speed/robot_steps_per_s": speed, "speed/environment_share": share}
        teller.scalars(self.done, numbers)
        return f"{speed:,.0f} robot steps/s, {share:.0%} of the time in the environment"

    def evaluate(self) -> CurvePoint:
        """Judge the policy on the held-back worlds, and keep it, the best and the state."""
        experiment, weights = self._experiment, self._weights
        save_policy(experiment.out / LATEST, weights, self._card({}))
        trips = {name: self._round_trips(name) for name in experiment.worlds_by_name}
        point = judged(self.done, self._simulated_s, trips)
        if all(point.value > each.value for each in self.curve):
            self._best = weights
        self.curve.append(point)
        best = {f"best.{name}": array for name, array in self._best.items()}
        arrays = {**state_of(self._model), **best}
        write_checkpoint(self._file, experiment.identity, self.curve, arrays)
        self.keep_best()
        return point

    def keep_best(self) -> None:
        """Write the best policy so far, with the curve so far."""
        best = max(self.curve, key=lambda point: point.value)
        save_policy(self._experiment.out / BEST, self._best, self._card(best.round_trips))

    def _round_trips(self, name: str) -> Int64[Array, " worlds"]:
        """Those of the latest policy in each held-back world of a scenario."""
        experiment = self._experiment
        scenario, seeds = experiment.worlds_by_name[name], experiment.held_back_seeds
        recipe = learned(experiment.recipe, experiment.layers, experiment.out / LATEST)
        episodes = run_episodes(scenario, recipe, seeds, experiment.physics)
        return np.array([each.round_trips for each in episodes])

    @property
    def _simulated_s(self) -> float:
        """Simulated time so far, summed over worlds [s]."""
        n_worlds = worlds_of(self._experiment)
        ticks = self.done / self._env.num_envs
        scenarios = self._experiment.worlds_by_name.items()
        return ticks * sum(n_worlds[name] * each.tick for name, each in scenarios)

    @property
    def _actors(self) -> dict[LayerName, Tower]:
        actors = cast(Towers, self._model.policy.mlp_extractor).actors
        return cast(dict[LayerName, Tower], dict(actors.items()))

    @property
    def _weights(self) -> dict[str, Float32[Array, "..."]]:
        """The arrays of the actors, as a policy's file names them."""
        return {
            f"{layer}.{name}": array
            for layer, actor in self._actors.items()
            for name, array in actor.as_in_file().items()
        }

    def _let_act(self, learn: bool) -> None:
        """Let the actors learn, or the critic alone."""
        self._model.policy.log_std.requires_grad_(learn)
        for actor in self._actors.values():
            actor.requires_grad_(learn)

    def _card(self, score: dict[str, Interval]) -> Card:
        experiment = self._experiment
        scenario = next(iter(experiment.worlds_by_name.values()))
        layers = {
            layer: layer_card(layer, scenario, actor.network, actor.sizes)
            for layer, actor in self._actors.items()
        }
        return card_of(experiment, layers, ("stable-baselines3", "torch"), self.curve, score)


def _seed(experiment: int, interval: int) -> int:
    """The seed of an interval's draws and worlds."""
    return int(np.random.SeedSequence([experiment, interval]).generate_state(1)[0])
