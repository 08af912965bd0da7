"""Train by what the extra `train` has: by stable-baselines3, by this PPO, by transitions.

Each trains one policy for all robots from scratch, for as many robot-steps as the watch says.
"""

import copy
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import torch
from sb3_contrib import RecurrentPPO
from stable_baselines3 import DQN, PPO, SAC
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.policies import BasePolicy

from swarm_forage_env.arrays import Array, Bool
from swarm_forage_env.envs.array_env import ArrayEnv
from training.actor_critic import ActorCritic, RecurrentActorCritic
from training.cloning import Cloner, CloningOptions
from training.experiment import FIRST_TRAINING_SEED, step_seed
from training.ladder.play import POINTS, Act, Watch
from training.ladder.rungs import Algorithm, Rung
from training.policy_card import CardKeywords
from training.ppo import PRESETS
from training.ppo_learner import PPOLearner
from training.tensor_vec_env import TensorVecEnv
from training.transitions import DatasetOptions, Recording, Transitions, read
from training.vec_env import SwarmVecEnv

MODELS = {"": PPO, "recurrent_ppo": RecurrentPPO, "sac": SAC, "dqn": DQN}
"""The algorithms, by their names."""

PRESET = PRESETS["everything"]

STRIDE = 1000  # steps of all environments between two looks at how far an off-policy training is


def by_sb3(rung: Rung, algorithm: Algorithm, seed: int, watch: Watch) -> None:
    """Train by PPO, RecurrentPPO, SAC or DQN of stable-baselines3."""
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
    """A policy of stable-baselines3 as the test worlds call it."""
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


def by_own_ppo(rung: Rung, algorithm: Algorithm, seed: int, watch: Watch) -> None:
    """Train by the PPO of `swarm-forage train everything`: a network with a memory."""
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
    """A network as the test worlds call it; a memory is kept of every robot."""
    states = torch.empty(0)

    @torch.no_grad()
    def act(observations: Array, begins: Bool[Array, " worlds"], by_chance: bool) -> Array:
        nonlocal states
        rows = torch.from_numpy(observations).flatten(0, 1)
        if isinstance(policy, RecurrentActorCritic):
            begun = torch.from_numpy(begins.repeat(observations.shape[1]))[:, None]
            before = torch.zeros(len(rows), policy.n_state) if begins.all() else states
            rows = states = policy.next_states(rows, torch.where(begun, 0.0, before))
        actions = policy(rows) if by_chance else policy.actor(rows)
        chosen: Array = actions.clamp(-1.0, 1.0).reshape(*observations.shape[:2], -1).numpy()
        return chosen

    return act


def by_transitions(rung: Rung, algorithm: Algorithm, seed: int, watch: Watch) -> None:
    """Train by transitions of other policies: behaviour cloning, reward-weighted regression.

    The transitions are of every tick, and so a policy drives the wheels in every tick, beside the
    same other layers as those of the other trainers. A robot-step is a transition that is read,
    each time that it is; the environment is stepped only to record them, and for evaluations.
    """
    torch.manual_seed(seed)
    torch.set_num_threads(1)
    settings = dict(algorithm.settings)
    played, keywords = record(rung, seed, **settings.pop("dataset"))
    watch.keywords = {**watch.keywords, **keywords.model_dump()}
    options = CloningOptions(**settings)
    cloner, n_read = Cloner(played, options), 0
    policy = cloner.policy
    while n_read < watch.robot_steps:
        cloner.step()
        n_read += options.batch
        if watch.due(n_read):
            watch.evaluate(n_read, acting(policy), lambda: acting(copy.deepcopy(policy)))


def record(
    rung: Rung, seed: int, policies: Sequence[str], episodes: int, learners: int
) -> tuple[Mapping[str, Array], CardKeywords]:
    """Transitions of a few robots of each episode, and the keywords under which they act.

    Each training has `episodes` seeds of its own, all of them seeds of trainings, the same for
    every policy.
    """
    changes = [f"{name}={value}" for name, value in rung.keywords.items() if "." in name]
    first, physics = FIRST_TRAINING_SEED + seed * episodes, rung.keywords.get("physics")
    request = DatasetOptions(rung.keywords["scenario"], policies, episodes, first, changes, physics)
    recordings = [Recording(each, learners) for each in request.configurations()]
    with TemporaryDirectory() as folder:
        store = Transitions(Path(folder))
        for recording in recordings:
            for _ in store.record(recording, request.seeds(), threads=1):
                pass
        return read(folder), recordings[0].card.keywords
