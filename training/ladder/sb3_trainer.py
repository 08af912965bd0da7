"""Train by stable-baselines3: PPO, one policy for all robots."""

from typing import Any

import torch
from stable_baselines3 import PPO
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.policies import ActorCriticPolicy

from swarm_forage_env.arrays import Array
from training.ladder.algorithms import Algorithm
from training.ladder.play import Act, Watch
from training.ladder.rungs import Rung
from training.vec_env import SwarmVecEnv


def is_discrete(algorithm: Algorithm) -> bool:
    """PPO takes numbers."""
    return False


def train(rung: Rung, algorithm: Algorithm, seed: int, watch: Watch) -> None:
    """Train from scratch, for as many robot-steps as the watch says."""
    torch.set_num_threads(1)
    keywords = {**rung.keywords, **algorithm.keywords}
    env = SwarmVecEnv(n_worlds=algorithm.worlds, seed=seed, stagger=True, **keywords)
    period = env.env.config.decision_period or 1
    model = PPO(
        "MlpPolicy",
        env,
        gamma=keywords["discount"],
        seed=seed,
        device="cpu",
        **algorithm.settings,
    )
    model.learn(-(-watch.robot_steps // period), callback=_Watcher(watch, period))


class _Watcher(BaseCallback):
    """Evaluates after updates, when it is time."""

    def __init__(self, watch: Watch, period: int) -> None:
        super().__init__()
        self._watch, self._period = watch, period

    def _on_step(self) -> bool:
        return True

    def _on_rollout_start(self) -> None:
        self._look()

    def _on_training_end(self) -> None:
        self._look()

    def _look(self) -> None:
        """Evaluate what the last update has made."""
        robot_steps = self.num_timesteps * self._period
        if self._watch.due(robot_steps):
            policy = self.model.policy
            self._watch.evaluate(robot_steps, _acting(policy), lambda: _acting(_copied(self.model)))


def _acting(policy: Any) -> Act:  # noqa: ANN401 a policy of any kind
    """The policy without its chance."""

    def act(observations: Array) -> Array:
        rows = observations.reshape(-1, observations.shape[-1])
        actions: Array = policy.predict(rows, deterministic=True)[0]
        return actions.reshape(*observations.shape[:2], *actions.shape[1:])

    return act


def _copied(model: BaseAlgorithm) -> ActorCriticPolicy:
    """The policy as it is now."""
    made = ActorCriticPolicy(model.observation_space, model.action_space, lambda _: 0.0)
    made.load_state_dict(model.policy.state_dict())
    return made
