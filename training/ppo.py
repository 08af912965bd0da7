"""PPO on the learned layers, with parameter sharing: one policy for all robots.

Training runs in intervals. Each resets the worlds with seeds of its own and ends with an
evaluation on held-back seeds and a checkpoint, so an interrupted run resumes from the last
interval and ends with the same result. The first interval of a motion trains the critic alone:
the motion starts as a clone of the controller's own, which an untrained critic would undo.

Source: Schulman2017, Proximal Policy Optimization Algorithms.
"""

import math
import time
from collections.abc import Callable, Mapping, Sequence
from typing import cast

import numpy as np
import torch

from baselines.evaluation.episode import run_episodes
from swarm_forage_env.arrays import Array, Float32, Int64
from swarm_forage_env.envs.array_env import array_env
from swarm_forage_env.loop import Loop
from swarm_forage_env.observed_fields import FieldLayout, read_rows
from swarm_forage_env.record import copied_rows
from training.actor_critic import LayerPolicy, MotionActor, NamedNetwork
from training.controllers import with_learned_layers
from training.experiment import Experiment, step_seed, worlds_per_scenario
from training.policy_file import LayerCard, LayerName, Policy, arrays_under, layer_card, save_policy
from training.ppo_learner import PPOHyperparameters, PPOLearner
from training.tensor_vec_env import TensorVecEnv
from training.training_loop import ProgressLogger, Training, run

EVERY_TICK = PPOHyperparameters(decision_period=1, discount=0.999, log_std=-2.0)
"""Hyperparameters for a decision in every tick: an exchange is observed for one tick only."""

HYPERPARAMETERS: Mapping[str, PPOHyperparameters] = {
    "weighting": EVERY_TICK,
    "motion": PPOHyperparameters(),
    "both": EVERY_TICK,
}
"""Hyperparameters for each choice of the trained layer."""

LATEST = "latest.safetensors"
"""File of the policy of the last interval."""

BEST = "best."
"""What the names of the best policy's arrays begin with in a checkpoint."""

DEMONSTRATORS = 80
"""Number of robots of each scenario that behaviour cloning records, about."""


def train(experiment: Experiment, say: Callable[[str], None]) -> Policy:
    """Run or resume an experiment with PPO, and return the best policy."""
    training = PPOTraining(experiment)
    if not training.curve:
        say(training.warm_start())
    return run(training, experiment, "robot step", say)


class PPOTraining(Training):
    """A resumable PPO training."""

    def __init__(self, experiment: Experiment) -> None:
        """Start a training, or resume it from the checkpoint in the experiment's folder."""
        super().__init__(experiment)
        torch.set_num_threads(experiment.workers)
        torch.manual_seed(experiment.seed)
        self._hyperparameters = terms = HYPERPARAMETERS[experiment.layer]
        self._env = make_env(experiment, terms)
        layout = self._env.observation_layout
        self._policy = LayerPolicy(layout, experiment.layers, terms.log_std)
        self._learner = PPOLearner(self._env, self._policy, terms)
        self._best = self._weights
        self._open()

    @property
    def done(self) -> int:
        """Robot steps (control ticks of single robots) completed so far."""
        return self._learner.n_decisions * self._hyperparameters.decision_period

    def warm_start(self) -> str:
        """Clone the controller's own motion, if the motion is learned; return a line to print."""
        actor, experiment = self._actors.get("motion"), self._experiment
        if not isinstance(actor, MotionActor):
            return "starting from nothing"
        torch.manual_seed(experiment.seed)
        pairs, layout = [], self._env.observation_layout
        for scenario in experiment.scenarios_by_name.values():
            n_worlds = max(1, DEMONSTRATORS // scenario.task.n_robots)
            seeds = experiment.training_seeds(0, n_worlds)
            loop = Loop(scenario, experiment.base_controller, seeds, experiment.physics)
            pairs.append(record_demonstrations(loop, layout))
        error = clone_behaviour(actor, pairs)
        return f"the motion of {experiment.controller} is copied; mean squared error {error:.3f}"

    def advance(self, progress: ProgressLogger) -> str:
        """Train for one interval in new worlds, and return a line on its speed."""
        experiment, learner, before = self._experiment, self._learner, self.done
        begin, stepping = time.perf_counter(), self._env.stepping_s
        left = max(0.0, 1.0 - before / experiment.budget)
        self._set_trainable(learn=len(self.curve) > 1 or "motion" not in self._actors)
        decisions = math.ceil(experiment.every / self._hyperparameters.decision_period)
        rate = self._hyperparameters.learning_rate * left
        learner.learn(decisions, rate, step_seed(experiment.seed, len(self.curve)))
        wall = time.perf_counter() - begin
        speed = (self.done - before) / wall
        share = (self._env.stepping_s - stepping) / wall
        speeds = {"speed/robot_steps_per_s": speed, "speed/environment_share": share}
        progress.log_scalars(self.done, {**speeds, **learner.diagnostics})
        return f"{speed:,.0f} robot steps/s, {share:.0%} of the time in the environment"

    def _round_trips(self) -> Mapping[str, Int64[Array, " worlds"]]:
        """Round trips of the latest policy, which is saved, in each held-back world."""
        experiment, file = self._experiment, self._experiment.out / LATEST
        save_policy(file, self._weights, self._card({}))
        controller = with_learned_layers(experiment.base_controller, experiment.layers, file)
        seeds, physics = experiment.held_back_seeds, experiment.physics
        found = {}
        for name, scenario in experiment.scenarios_by_name.items():
            episodes = run_episodes(scenario, controller, seeds, physics)
            found[name] = np.array([each.round_trips for each in episodes])
        return found

    @property
    def _state(self) -> dict[str, Array]:
        best = {BEST + name: array for name, array in self._best.items()}
        return self._learner.state() | best

    def _restore(self, arrays: Mapping[str, Array]) -> None:
        self._learner.restore(arrays)
        self._best = arrays_under(BEST, arrays)

    @property
    def _simulated_s(self) -> float:
        n_worlds = worlds_per_scenario(self._experiment)
        ticks = self.done / self._env.n_rows
        scenarios = self._experiment.scenarios_by_name.items()
        return ticks * sum(n_worlds[name] * each.tick for name, each in scenarios)

    @property
    def _actors(self) -> dict[LayerName, NamedNetwork]:
        return cast(dict[LayerName, NamedNetwork], dict(self._policy.actors.items()))

    @property
    def _weights(self) -> dict[str, Float32[Array, "..."]]:
        return {
            f"{layer}.{name}": array
            for layer, actor in self._actors.items()
            for name, array in actor.to_numpy().items()
        }

    def _set_trainable(self, learn: bool) -> None:
        self._policy.log_std.requires_grad_(learn)
        for actor in self._actors.values():
            actor.requires_grad_(learn)

    @property
    def _layers(self) -> dict[LayerName, LayerCard]:
        scenario = next(iter(self._experiment.scenarios_by_name.values()))
        return {
            layer: layer_card(layer, scenario, actor.network, actor.sizes)
            for layer, actor in self._actors.items()
        }


def make_env(experiment: Experiment, hyperparameters: PPOHyperparameters) -> TensorVecEnv:
    """Make the robots of all scenarios of an experiment, on its device."""
    return TensorVecEnv(
        [
            array_env(
                experiment.scenarios_by_name[name],
                device=experiment.device,
                n_worlds=n_worlds,
                controller=experiment.base_controller,
                learn=experiment.layer,
                action="wheels",
                normalise=False,
                physics=experiment.physics,
                decision_period=hyperparameters.decision_period,
                discount=hyperparameters.discount,
                shaping=hyperparameters.shaping,
            )
            for name, n_worlds in worlds_per_scenario(experiment).items()
        ]
    )


SAMPLE_EVERY = 20
"""Ticks between two samples of a world; samples of successive ticks are highly correlated."""

EPOCHS, BATCH_SIZE, LEARNING_RATE = 20, 512, 1e-3

Demonstrations = tuple[Float32[Array, "samples numbers"], Float32[Array, "samples 2"]]


def clone_behaviour(actor: MotionActor, pairs: Sequence[Demonstrations]) -> float:
    """Fit a motion network to demonstrations; return its mean squared error in the last epoch.

    Subsumption has memory and draws random numbers, the network does neither: the clone learns the
    mean behaviour, without the random walk, and without the side on which an obstacle is passed.

    Batches are drawn from torch's global generator: seed it for a repeatable fit.
    """
    device = next(actor.parameters()).device
    observed = torch.from_numpy(np.concatenate([each[0] for each in pairs])).to(device)
    wheels = torch.from_numpy(np.concatenate([each[1] for each in pairs])).to(device)
    optimiser = torch.optim.Adam(actor.parameters(), LEARNING_RATE)
    for _ in range(EPOCHS):
        total = 0.0
        for rows in torch.split(torch.randperm(len(observed)), BATCH_SIZE):
            given, _ = actor(observed[rows])
            loss = torch.mean((given - wheels[rows]) ** 2)
            optimiser.zero_grad()
            loss.backward()  # type: ignore[no-untyped-call]
            optimiser.step()
            total += loss.item() * len(rows)
    return total / len(observed)


def record_demonstrations(loop: Loop, layout: FieldLayout) -> Demonstrations:
    """Record observations and wheel speeds over a whole episode of a hand-written controller."""
    read, fields, world = loop.kernel(read_rows, {}), loop.fields(layout), loop.world
    everybody = np.arange(world.robots.shape[1])
    observed, wheels = [], []
    for tick in range(loop.world.scenario.n_ticks):
        if tick % SAMPLE_EVERY == 0:
            seen = np.empty((*world.robots.shape, len(layout)), np.float32)
            read(fields, everybody, seen)
            observed.append(seen.reshape(-1, len(layout)))
        loop.step()
        if tick % SAMPLE_EVERY == 0:  # what was commanded is shown as the last wheels
            wheels.append(copied_rows(world.robots, ("command", "wheels")))
    return np.concatenate(observed), np.concatenate(wheels)
