"""Train by the PPO of `swarm-forage train everything`: a network with a memory of each robot."""

import copy
from dataclasses import replace

import torch

from swarm_forage_env.arrays import Array, Bool
from swarm_forage_env.envs.array_env import ArrayEnv
from training.actor_critic import ActorCritic, RecurrentActorCritic
from training.experiment import step_seed
from training.ladder.play import POINTS, Act, Watch
from training.ladder.rungs import Algorithm, Rung
from training.ppo import PRESETS
from training.ppo_learner import PPOLearner
from training.tensor_vec_env import TensorVecEnv

PRESET = PRESETS["everything"]


def train(rung: Rung, algorithm: Algorithm, seed: int, watch: Watch) -> None:
    """Train from scratch, for as many robot-steps as the watch says."""
    torch.manual_seed(seed)
    torch.set_num_threads(1)
    keywords = {**rung.keywords, **algorithm.keywords}
    env = TensorVecEnv([ArrayEnv(n_worlds=algorithm.worlds, **keywords)])
    sizes = len(env.observation_layout), len(env.blocks[0].action_layout)
    policy = RecurrentActorCritic(*sizes, log_std=PRESET.log_std)
    changes = {"discount": keywords["discount"], **algorithm.settings}
    learner = PPOLearner(env, policy, replace(PRESET.hyperparameters, **changes))
    for part in range(POINTS):
        learner.learn(watch.robot_steps // POINTS, step_seed(seed, part))
        watch.evaluate(learner.robot_steps, acting(policy), lambda: acting(copy.deepcopy(policy)))


def acting(policy: ActorCritic) -> Act:
    """The policy as the test worlds call it; a memory is kept of every robot."""
    states = torch.empty(0)

    @torch.no_grad()
    def act(observations: Array, begins: Bool[Array, " worlds"], by_chance: bool) -> Array:
        nonlocal states
        rows = torch.from_numpy(observations).flatten(0, 1)
        if isinstance(policy, RecurrentActorCritic):
            begun = torch.from_numpy(begins.repeat(observations.shape[1]))[:, None]
            before = torch.zeros(len(rows), policy.n_state) if begins.all() else states
            rows = states = policy.next_states(rows, torch.where(begun, 0.0, before))
        actions = policy(rows)[0] if by_chance else policy.actor(rows)
        chosen: Array = actions.clamp(-1.0, 1.0).reshape(*observations.shape[:2], -1).numpy()
        return chosen

    return act
