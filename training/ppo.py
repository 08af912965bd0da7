"""PPO from scratch, with one policy for all robots.

Observations and actions are those of `parallel_env(scenario, learn=layer)` with the keywords of
`PRESETS`. The reward is round trips, as for every other trainer, but a weighting is rewarded by the
error of estimates (`training.exchanges`). Training runs in intervals. Each resets the worlds with
new seeds and ends with an evaluation on held-back seeds and a checkpoint, so that an interrupted
run resumes from the last interval and ends with the same result.

Source: Schulman2017, Proximal Policy Optimization Algorithms.
"""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import torch

from baselines.controller import LayeredController
from baselines.evaluation.episode import run_episodes
from swarm_forage_env.arrays import Array, Int64
from swarm_forage_env.envs.array_env import ArrayEnv
from swarm_forage_env.envs.keywords import EnvOptions, OwnName
from swarm_forage_env.envs.make import checked_parts
from swarm_forage_env.worlds_on_cpu import checked_device
from training.actor_critic import ActorCritic, RecurrentActorCritic
from training.exchanges import ErrorRewardVecEnv
from training.experiment import Experiment, step_seed, worlds_per_scenario
from training.network_policy import NetworkPolicy, save_network
from training.policy_card import card_of
from training.policy_controller import PolicyController, named_policy
from training.policy_file import Interval, Weights
from training.ppo_learner import PPOHyperparameters, PPOLearner
from training.tensor_vec_env import TensorVecEnv
from training.training_loop import ProgressLogger, Training, run

MANY = 1000
"""Number of worlds from which the hyperparameters for many worlds are used."""


@dataclass(frozen=True)
class Preset:
    """Settings for the training of a layer; the defaults are those of the motion."""

    keywords: EnvOptions = field(default_factory=EnvOptions)
    """Keywords of the environment that differ from its defaults."""
    hyperparameters: PPOHyperparameters = field(default_factory=PPOHyperparameters)
    many_worlds: PPOHyperparameters | None = None
    """Hyperparameters from `MANY` worlds on, whose rollouts are a small part of an episode. The
    ends of episodes are then staggered, and values are 0 at first (decision 0047). None: as with
    few worlds."""
    stagger: bool = False
    """Whether the ends of episodes are staggered with few worlds, too."""
    log_std: float = 0.0  # logarithm of the standard deviation of actions before the first update
    network: type[ActorCritic] = ActorCritic
    vec_env: type[TensorVecEnv] = TensorVecEnv


MANY_WORLDS = PPOHyperparameters(n_steps=32, n_minibatches=8, n_epochs=4, learning_rate=2e-3)
"""Hyperparameters for thousands of worlds: the best of six by the round trips after six seconds on
a GPU (docs/guides/gpu.md)."""

PRESETS: Mapping[str, Preset] = {
    "weighting": Preset(
        {"step_on": "exchange"},
        PPOHyperparameters(n_steps=256, n_minibatches=4, discount=0.0),
        log_std=-0.7,
        vec_env=ErrorRewardVecEnv,
    ),
    "motion": Preset(many_worlds=MANY_WORLDS),
    "both": Preset(many_worlds=MANY_WORLDS),
    "everything": Preset(
        {"decision_period": 10, "shaping": 1.0, "discount": 0.99},
        PPOHyperparameters(n_steps=64, n_minibatches=8, n_epochs=3, learning_rate=5e-4),
        log_std=-0.5,
        stagger=True,
        network=RecurrentActorCritic,
    ),
}
"""Preset for each choice of the trained layer, chosen on es1: for the motion after 6 million
robot-steps (decision 0033), for the weighting by decisions 0034 and 0043."""

LATEST = "latest.safetensors"  # file of the policy of the last interval


def train(experiment: Experiment, say: Callable[[str], None]) -> PolicyController:
    """Run or resume an experiment with PPO, and return the best policy as a controller."""
    file = run(PPOTraining(experiment), experiment, "robot step", say)
    return controller_of(file, base_controller(experiment))


def controller_of(file: Path, controller: LayeredController | None = None) -> PolicyController:
    """Return the controller of a policy saved by PPO, over `controller` or that of its card."""
    terms = {"file": str(file), "controller": controller}
    return named_policy("network", NetworkPolicy()).with_parameters(terms)


class PPOTraining(Training):
    """A resumable PPO training."""

    def __init__(self, experiment: Experiment) -> None:
        super().__init__(experiment)
        torch.set_num_threads(1)  # faster for such small networks
        torch.manual_seed(experiment.seed)
        env = make_env(experiment)
        preset, n_observed = PRESETS[experiment.layer], len(env.observation_layout)
        n_actions = len(env.blocks[0].action_layout)
        terms = for_many_worlds(experiment)
        gain = 0.0 if terms else 1.0
        policy = preset.network(n_observed, n_actions, log_std=preset.log_std, value_gain=gain)
        self._learner = PPOLearner(env, policy, terms or preset.hyperparameters)
        self._open()

    @property
    def done(self) -> int:
        """Robot steps (control ticks of single robots) completed so far."""
        return self._learner.robot_steps

    def advance(self, progress: ProgressLogger) -> str:
        """Train for one interval in new worlds, and return a line on its speed."""
        experiment, learner, before = self._experiment, self._learner, self.done
        begin, stepping = time.perf_counter(), learner.env.stepping_s
        learner.learn(experiment.every, step_seed(experiment.seed, len(self.curve)))
        wall = time.perf_counter() - begin
        speed = (self.done - before) / wall
        share = (learner.env.stepping_s - stepping) / wall
        speeds = {"speed/robot_steps_per_s": speed, "speed/environment_share": share}
        progress.log_scalars(self.done, {**speeds, **learner.diagnostics})
        return f"{speed:,.0f} robot steps/s, {share:.0%} of the time in the environment"

    def _round_trips(self) -> Mapping[str, Int64[Array, " worlds"]]:
        """Return the round trips of the latest policy, which is saved, in each held-back world."""
        experiment, file = self._experiment, self._experiment.out / LATEST
        self._write(file, self._weights, {})
        controller = controller_of(file, base_controller(experiment))
        seeds, physics = experiment.held_back_seeds, experiment.physics
        trips = {}
        for name, scenario in experiment.scenarios_by_name.items():
            episodes = run_episodes(scenario, controller, seeds, physics)
            trips[name] = np.array([each.round_trips for each in episodes])
        return trips

    def _write(self, file: Path, weights: Weights, score: Mapping[str, Interval]) -> None:
        experiment = self._experiment
        scenario = next(iter(experiment.scenarios_by_name.values()))
        parts = checked_parts(scenario, base_controller(experiment), keywords(experiment))
        card = card_of(parts).model_copy(update={"training": self._record(score)})
        save_network(file, weights, card)

    @property
    def _state(self) -> dict[str, Array]:
        return self._learner.state()

    def _restore(self, arrays: Mapping[str, Array]) -> None:
        self._learner.restore(arrays)

    @property
    def _simulated_s(self) -> float:
        n_worlds = worlds_per_scenario(self._experiment)
        ticks = self.done / self._learner.env.n_rows
        scenarios = self._experiment.scenarios_by_name.items()
        return ticks * sum(n_worlds[name] * each.tick for name, each in scenarios)

    @property
    def _weights(self) -> Weights:
        return self._learner.policy.to_numpy()


def keywords(experiment: Experiment) -> EnvOptions:
    """Return the keywords of `parallel_env` under which an experiment trains."""
    physics = OwnName(experiment.physics)
    terms: EnvOptions = {"learn": OwnName(experiment.layer), "physics": physics}
    if experiment.device == "cpu":
        terms["threads"] = experiment.workers
    return {**terms, **PRESETS[experiment.layer].keywords}


def base_controller(experiment: Experiment) -> LayeredController | None:
    """Return the controller of the layers that are not trained; None if there are none."""
    return None if experiment.layer == "everything" else experiment.base_controller


def for_many_worlds(experiment: Experiment) -> PPOHyperparameters | None:
    """Return the hyperparameters for many worlds if the experiment has that many."""
    return PRESETS[experiment.layer].many_worlds if experiment.worlds >= MANY else None


def make_env(experiment: Experiment) -> TensorVecEnv:
    """Make the environment of all scenarios of an experiment, on its device."""
    preset, has_many = PRESETS[experiment.layer], for_many_worlds(experiment) is not None
    return preset.vec_env(
        [
            ArrayEnv(
                experiment.scenarios_by_name[name],
                device=checked_device(experiment.device),
                n_worlds=n_worlds,
                controller=base_controller(experiment),
                stagger=preset.stagger or has_many,
                **keywords(experiment),
            )
            for name, n_worlds in worlds_per_scenario(experiment).items()
        ]
    )
