"""Set-up of stable-baselines3's PPO: hyperparameters, environments, model and model state."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol, cast

import numpy as np
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.logger import KVWriter, Logger
from stable_baselines3.common.policies import ActorCriticPolicy
from stable_baselines3.common.utils import FloatSchedule, set_random_seed

from swarm_forage_env.arrays import Array
from swarm_forage_env.observed_fields import FieldLayout
from training.actor_critic import LayerActorCriticPolicy
from training.experiment import Experiment, worlds_per_scenario
from training.multi_scenario_vec_env import MultiScenarioVecEnv
from training.progress import FOLDER, EventFile
from training.vec_env import SwarmVecEnv

MOMENTS = ("step", "exp_avg", "exp_avg_sq")
"""Entries of Adam's state for each parameter."""


class Learner(Protocol):
    """PPO on the rows of an environment, a row for each robot that learns."""

    num_timesteps: int
    told: dict[str, float]

    @property
    def policy(self) -> ActorCriticPolicy:
        """Networks and optimiser."""
        ...

    @property
    def observation_layout(self) -> FieldLayout:
        """What a row of an observation is made of."""
        ...

    @property
    def n_rows(self) -> int:
        """Robots that learn, in all worlds."""
        ...

    @property
    def stepping_s(self) -> float:
        """Wall time of all steps of the worlds [s]."""
        ...

    def learn(self, decisions: int, learning_rate: float, seed: int) -> None:
        """Learn from so many decisions of single robots, in whole rollouts."""
        ...

    def worlds_state(self) -> dict[str, Array]:
        """What worlds that go on after `learn` go on from, by name."""
        ...

    def restore_worlds(self, state: Mapping[str, Array]) -> None:
        """Let the worlds go on as when `worlds_state` told this."""
        ...


@dataclass(frozen=True)
class PPOHyperparameters:
    """Hyperparameters of PPO."""

    decision_period: int = 2
    """Ticks for which an action is held. An exchange takes a few ticks, during which a robot must
    stop: a longer period would miss it."""
    discount: float = 0.998
    """Discount factor of one decision; the mean horizon is 100 s, about a round trip."""
    gae_lambda: float = 0.98
    """Lambda of generalised advantage estimation."""
    shaping: float = 1.0
    """Weight of the potential-based reward shaping."""
    n_steps: int = 256
    """Decisions of each robot in one rollout."""
    n_minibatches: int = 4
    """Minibatches per rollout and epoch."""
    n_epochs: int = 4
    learning_rate: float = 4e-4
    """Initial learning rate; it falls linearly to zero over the budget."""
    log_std: float = -1.2
    """Initial logarithm of the standard deviation of the actions."""


EVERY_TICK = PPOHyperparameters(decision_period=1, discount=0.999, log_std=-2.0)
"""Hyperparameters for a decision in every tick: an exchange is observed for one tick only."""

HYPERPARAMETERS: Mapping[str, PPOHyperparameters] = {
    "weighting": EVERY_TICK,
    "motion": PPOHyperparameters(),
    "both": EVERY_TICK,
}
"""Hyperparameters for each choice of the trained layer."""


def make_vec_env(
    experiment: Experiment, hyperparameters: PPOHyperparameters
) -> MultiScenarioVecEnv:
    """Make the vector environment over the robots of all scenarios of an experiment."""
    scenarios, options = experiment.scenarios_by_name, env_options(experiment, hyperparameters)
    return MultiScenarioVecEnv(
        [
            SwarmVecEnv(scenarios[name], n_worlds=n_worlds, **options)
            for name, n_worlds in worlds_per_scenario(experiment).items()
        ]
    )


def env_options(experiment: Experiment, hyperparameters: PPOHyperparameters) -> dict[str, Any]:
    """The keywords of the environments of an experiment, but for scenario and worlds."""
    return {
        "controller": experiment.base_controller,
        "learn": experiment.layer,
        "action": "wheels",
        "normalise": False,
        "physics": experiment.physics,
        "decision_period": hyperparameters.decision_period,
        "discount": hyperparameters.discount,
        "shaping": hyperparameters.shaping,
    }


def make_ppo(
    environment: MultiScenarioVecEnv, experiment: Experiment, hyperparameters: PPOHyperparameters
) -> PPO:
    """Make stable-baselines3's PPO with the networks of the learned layers."""
    model = PPO(
        LayerActorCriticPolicy,
        environment,
        learning_rate=hyperparameters.learning_rate,
        n_steps=hyperparameters.n_steps,
        batch_size=hyperparameters.n_steps * environment.num_envs // hyperparameters.n_minibatches,
        n_epochs=hyperparameters.n_epochs,
        gamma=hyperparameters.discount,
        gae_lambda=hyperparameters.gae_lambda,
        policy_kwargs={
            "layout": environment.observation_layout,
            "layers": experiment.layers,
            "log_std_init": hyperparameters.log_std,
        },
        seed=experiment.seed,
        device="cpu",
    )
    model.set_logger(Logger(folder=None, output_formats=[Curves(experiment.out / FOLDER)]))
    return model


class SB3Learner:
    """stable-baselines3's PPO on the robots of all scenarios of an experiment, on a CPU."""

    def __init__(self, experiment: Experiment, hyperparameters: PPOHyperparameters) -> None:
        """Start with new networks, and seed all generators of this process."""
        self._env = make_vec_env(experiment, hyperparameters)
        self._model = make_ppo(self._env, experiment, hyperparameters)
        self.told: dict[str, float] = {}
        """What is told of the last update: nothing, as SB3 logs it itself."""

    @property
    def policy(self) -> ActorCriticPolicy:
        """Networks and optimiser."""
        return self._model.policy

    @property
    def num_timesteps(self) -> int:
        """Decisions of single robots so far."""
        return int(self._model.num_timesteps)

    @num_timesteps.setter
    def num_timesteps(self, number: int) -> None:
        self._model.num_timesteps = number

    @property
    def observation_layout(self) -> FieldLayout:
        """What a row of an observation is made of."""
        return cast(FieldLayout, self._env.observation_layout)

    @property
    def n_rows(self) -> int:
        """Robots that learn, in all worlds."""
        return self._env.num_envs

    @property
    def stepping_s(self) -> float:
        """Wall time of all steps of the worlds [s]."""
        return self._env.stepping_s

    def learn(self, decisions: int, learning_rate: float, seed: int) -> None:
        """Learn in new worlds from so many decisions of single robots, in whole rollouts."""
        set_random_seed(seed)
        self._env.seed(seed)
        self._model._last_obs = None  # so that learning starts with a reset
        self._model.lr_schedule = FloatSchedule(learning_rate)
        self._model.learn(decisions, reset_num_timesteps=False)

    def worlds_state(self) -> dict[str, Array]:
        """Nothing: every call of `learn` begins with new worlds."""
        return {}

    def restore_worlds(self, state: Mapping[str, Array]) -> None:
        """There is nothing to restore."""


class Curves(KVWriter):
    """Writes what stable-baselines3 logs of the training to a file of curves."""

    def __init__(self, folder: Path) -> None:
        """Start a file in a folder."""
        self._file = EventFile(folder)

    def write(
        self,
        key_values: dict[str, Any],
        key_excluded: dict[str, tuple[str, ...]],
        step: int = 0,
    ) -> None:
        """Write every number at one step."""
        for name, value in key_values.items():
            shown = "tensorboard" not in (key_excluded[name] or ())
            if shown and isinstance(value, int | float | np.number):
                self._file.add_scalar(name, float(value), step)

    def close(self) -> None:
        """Do nothing: the file is open only while a number is written."""


def model_state(model: Learner) -> dict[str, Array]:
    """The state of a model as arrays: parameters, Adam's moments and the number of steps."""
    arrays = {f"policy.{name}": array for name, array in model.policy.state_dict().items()}
    remembered = model.policy.optimizer.state
    for name, parameter in model.policy.named_parameters():
        for moment in MOMENTS:
            kept = remembered.get(parameter, {}).get(moment)
            empty = torch.zeros(() if moment == "step" else parameter.shape)
            arrays[f"{moment}.{name}"] = empty if kept is None else kept
    found = {name: array.detach().cpu().numpy().copy() for name, array in arrays.items()}
    return {**found, "num_timesteps": np.array(model.num_timesteps)}


def restore_model(model: Learner, arrays: Mapping[str, Array]) -> None:
    """Restore a model to a state that `model_state` returned."""
    tensors = {name: torch.from_numpy(np.array(array)) for name, array in arrays.items()}
    policy = model.policy
    policy.load_state_dict({name: tensors[f"policy.{name}"] for name in policy.state_dict()})
    for name, parameter in policy.named_parameters():
        if tensors[f"step.{name}"] > 0:
            moments = {moment: tensors[f"{moment}.{name}"] for moment in MOMENTS}
            moved = {k: v if k == "step" else v.to(parameter.device) for k, v in moments.items()}
            policy.optimizer.state[parameter] = moved
    model.num_timesteps = int(arrays["num_timesteps"])
