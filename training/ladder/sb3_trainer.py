"""Train by stable-baselines3: PPO, one policy for all robots."""

import torch
from stable_baselines3 import PPO
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.policies import ActorCriticPolicy, BasePolicy

from swarm_forage_env.arrays import Array
from training.ladder.play import Act, Watch
from training.ladder.rungs import Algorithm, Rung
from training.vec_env import SwarmVecEnv


def is_discrete(algorithm: Algorithm) -> bool:
    """PPO takes numbers."""
    return False


def train(rung: Rung, algorithm: Algorithm, seed: int, watch: Watch) -> None:
    """Train from scratch, for as many robot-steps as the watch says."""
    torch.set_num_threads(1)
    keywords = {**rung.keywords, **algorithm.keywords}
    env = SwarmVecEnv(n_worlds=algorithm.worlds, seed=seed, stagger=True, **keywords)
    model = PPO(
        "MlpPolicy", env, gamma=keywords["discount"], seed=seed, device="cpu", **algorithm.settings
    )
    while env.env.robot_steps < watch.robot_steps:
        model.learn(1, reset_num_timesteps=False)  # one rollout, and the updates of it
        if watch.due(env.env.robot_steps):
            acting = _acting(model.policy)
            watch.evaluate(env.env.robot_steps, acting, lambda: _acting(_copied(model)))


def _acting(policy: BasePolicy) -> Act:
    def act(observations: Array) -> Array:
        rows = observations.reshape(-1, observations.shape[-1])
        actions: Array = policy.predict(rows, deterministic=True)[0]
        return actions.reshape(*observations.shape[:2], *actions.shape[1:])

    return act


def _copied(model: BaseAlgorithm) -> ActorCriticPolicy:
    made = ActorCriticPolicy(model.observation_space, model.action_space, lambda _: 0.0)
    made.load_state_dict(model.policy.state_dict())
    return made
