"""Train by stable-baselines3: PPO, RecurrentPPO, SAC or DQN, one policy for all robots."""

import numpy as np
import torch
from sb3_contrib import RecurrentPPO
from stable_baselines3 import DQN, PPO, SAC
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.policies import BasePolicy

from swarm_forage_env.arrays import Array, Bool
from training.ladder.play import Act, Watch
from training.ladder.rungs import Algorithm, Rung
from training.vec_env import SwarmVecEnv

MODELS = {"": PPO, "recurrent_ppo": RecurrentPPO, "sac": SAC, "dqn": DQN}
"""The algorithms, by their names."""

STRIDE = 1000  # steps of all environments between two looks at how far an off-policy training is


def train(rung: Rung, algorithm: Algorithm, seed: int, watch: Watch) -> None:
    """Train from scratch, for as many robot-steps as the watch says."""
    torch.set_num_threads(1)
    keywords = {**rung.keywords, **algorithm.keywords}
    if algorithm.algorithm == "dqn":  # takes choices, the others numbers
        keywords["discrete"] = keywords.get("discrete") or True
        watch.keywords = {**watch.keywords, "discrete": keywords["discrete"]}
    env = SwarmVecEnv(n_worlds=algorithm.worlds, seed=seed, stagger=True, **keywords)
    policy = "MlpLstmPolicy" if algorithm.algorithm == "recurrent_ppo" else "MlpPolicy"
    model = MODELS[algorithm.algorithm](
        policy, env, gamma=keywords["discount"], seed=seed, device="cpu", **algorithm.settings
    )
    stride = STRIDE if algorithm.algorithm else 1
    while env.env.robot_steps < watch.robot_steps:
        model.learn(stride, reset_num_timesteps=False)  # of PPO one rollout, and its updates
        if watch.due(env.env.robot_steps):
            acting = _acting(model.policy)
            watch.evaluate(env.env.robot_steps, acting, lambda: _acting(_copied(model)))


def _acting(policy: BasePolicy) -> Act:
    states: tuple[Array, ...] | None = None

    def act(observations: Array, begins: Bool[Array, " worlds"], by_chance: bool) -> Array:
        nonlocal states
        rows = observations.reshape(-1, observations.shape[-1])
        starts = np.repeat(begins, observations.shape[1])
        before = None if begins.all() else states
        actions, states = policy.predict(rows, before, starts, deterministic=not by_chance)
        return actions.reshape(*observations.shape[:2], *actions.shape[1:])

    return act


def _copied(model: BaseAlgorithm) -> BasePolicy:
    made = type(model.policy)(model.observation_space, model.action_space, lambda _: 0.0)
    made.load_state_dict(model.policy.state_dict())
    return made
