"""Training with the extra `train`: stable-baselines3, the PPO of this package, transitions.

Each function trains one policy for all robots from scratch, for the robot-steps of the watch.
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
"""Classes of stable-baselines3, by the name of the algorithm."""

PRESET = PRESETS["everything"]

STRIDE = 1000  # steps, summed over environments, between two checks of an off-policy training


def by_sb3(rung: Rung, algorithm: Algorithm, seed: int, watch: Watch) -> None:
    """Train with PPO, RecurrentPPO, SAC or DQN of stable-baselines3."""
    torch.set_num_threads(1)
    keywords = {**rung.keywords, **algorithm.keywords}
    if algorithm.algorithm == "dqn":  # needs discrete actions
        keywords["discrete"] = keywords.get("discrete") or True
        watch.keywords = {**watch.keywords, "discrete": keywords["discrete"]}
    env = SwarmVecEnv(n_worlds=algorithm.worlds, seed=seed, stagger=True, **keywords)
    policy = "MlpLstmPolicy" if algorithm.algorithm == "recurrent_ppo" else "MlpPolicy"
    model = MODELS[algorithm.algorithm](
        policy, env, gamma=keywords["discount"], seed=seed, device="cpu", **algorithm.settings
    )
    stride = STRIDE if algorithm.algorithm else 1
    while env.env.robot_steps < watch.robot_steps:
        # for PPO one rollout and its updates; the exploration of DQN has its last value at once
        model.learn(stride, reset_num_timesteps=False)
        if watch.due(env.env.robot_steps):
            acting = _acting(model.policy)
            watch.evaluate(env.env.robot_steps, acting, lambda: _acting(_copied(model)))


def _acting(policy: BasePolicy) -> Act:
    """Return a policy of stable-baselines3 as an `Act`."""
    states: tuple[Array, ...] | None = None

    def act(observations: Array, begins: Bool[Array, " worlds"], stochastic: bool) -> Array:
        nonlocal states
        rows = observations.reshape(-1, observations.shape[-1])
        starts = np.repeat(begins, observations.shape[1])
        before = None if begins.all() else states
        actions, states = policy.predict(rows, before, starts, deterministic=not stochastic)
        return actions.reshape(*observations.shape[:2], *actions.shape[1:])

    return act


def _copied(model: BaseAlgorithm) -> BasePolicy:
    made = type(model.policy)(model.observation_space, model.action_space, lambda _: 0.0)
    made.load_state_dict(model.policy.state_dict())
    return made


def by_own_ppo(rung: Rung, algorithm: Algorithm, seed: int, watch: Watch) -> None:
    """Train with the PPO of `swarm-forage train everything`: a recurrent network."""
    torch.manual_seed(seed)
    torch.set_num_threads(1)
    keywords = {**rung.keywords, **algorithm.keywords}
    env = TensorVecEnv([ArrayEnv(n_worlds=algorithm.worlds, stagger=PRESET.stagger, **keywords)])
    sizes = len(env.observation_layout), len(env.blocks[0].action_layout)
    policy = RecurrentActorCritic(*sizes, log_std=PRESET.log_std)
    changes = {"discount": keywords["discount"], **algorithm.settings}
    learner = PPOLearner(env, policy, replace(PRESET.hyperparameters, **changes))
    for part in range(POINTS):
        learner.learn(watch.robot_steps // POINTS, step_seed(seed, part))
        watch.evaluate(learner.robot_steps, acting(policy), lambda: acting(copy.deepcopy(policy)))


def acting(policy: ActorCritic) -> Act:
    """Return a network as an `Act`, which keeps the recurrent states of all robots."""
    states = torch.empty(0)

    @torch.no_grad()
    def act(observations: Array, begins: Bool[Array, " worlds"], stochastic: bool) -> Array:
        nonlocal states
        rows = torch.from_numpy(observations).flatten(0, 1)
        if isinstance(policy, RecurrentActorCritic):
            begun = torch.from_numpy(begins.repeat(observations.shape[1]))[:, None]
            before = torch.zeros(len(rows), policy.n_state) if begins.all() else states
            rows = states = policy.next_states(rows, torch.where(begun, 0.0, before))
        actions = policy(rows) if stochastic else policy.actor(rows)
        chosen: Array = actions.clamp(-1.0, 1.0).reshape(*observations.shape[:2], -1).numpy()
        return chosen

    return act


def by_transitions(rung: Rung, algorithm: Algorithm, seed: int, watch: Watch) -> None:
    """Train on transitions of other policies: behaviour cloning or reward-weighted regression.

    The transitions are of every tick, so that the policy drives the wheels in every tick; the other
    layers are those of the other trainers. Every transition that is read counts as a robot-step.
    The environment is stepped only to record transitions and to evaluate.
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
    """Record transitions of some robots of each episode; also return the keywords of the policy.

    Each training has its own `episodes` training seeds, the same for every policy.
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
