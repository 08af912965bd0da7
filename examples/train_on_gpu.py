"""PPO from scratch on one GPU: worlds, policy and learner stay there, scores are of the CPU.

    pip install 'swarm-forage[cuda,train]'
    python examples/train_on_gpu.py                             # 1024 worlds of es1 on a GPU
    python examples/train_on_gpu.py --device cpu --worlds 8     # the same on a CPU, in minutes
    swarm-forage evaluate es1 ssgikf sb3:runs/train_on_gpu/model.zip

One policy learns how all robots steer. After each interval it is written to a file, and its round
trips are the mean over 30 worlds under the engine `rigid`, which runs on the CPU; the clock of the
training stands still meanwhile. No figure of a GPU has been taken with it yet.
"""

import argparse
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.policies import ActorCriticPolicy

from baselines.evaluation.episode import run_episodes
from swarm_forage_env import array_env
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.scenarios import find_scenario
from training.ppo_learner import PPOHyperparameters, PPOLearner
from training.tensor_vec_env import TensorVecEnv
from training.vec_env import SwarmVecEnv

TERMS = PPOHyperparameters(
    decision_period=10,
    discount=0.99,
    gae_lambda=0.95,
    shaping=1.0,
    n_steps=128,
    n_minibatches=10,
    n_epochs=10,
    learning_rate=3e-4,
    log_std=-0.7,
)
"""Those of `sb3_ppo.py`, which learns this on a CPU."""

SEEDS = range(1000, 1030)
"""Of the worlds that a policy is scored in."""


def make_learner(device: str, n_worlds: int, shaping: float, seed: int) -> PPOLearner:
    """PPO on es1 and a new policy, on one device."""
    env = array_env(
        "es1",
        device=device,
        n_worlds=n_worlds,
        stagger=True,
        physics="kinematic",
        decision_period=TERMS.decision_period,
        discount=TERMS.discount,
        shaping=shaping,
    )
    tensors = TensorVecEnv([env])
    torch.manual_seed(seed)
    policy = ActorCriticPolicy(
        tensors.observation_space,
        tensors.action_space,
        lambda _: TERMS.learning_rate,
        log_std_init=TERMS.log_std,
    )
    return PPOLearner(tensors, policy, TERMS)


def save(policy: ActorCriticPolicy, file: Path) -> None:
    """Write the policy as a model of stable-baselines3, which tells what it was trained under."""
    env = SwarmVecEnv("es1", n_worlds=1, physics="kinematic", decision_period=TERMS.decision_period)
    model = PPO("MlpPolicy", env, device="cpu")
    model.policy.load_state_dict(policy.state_dict())
    model.save(file)


def round_trips(file: Path, n_worlds: int) -> float:
    """The mean round trips of an episode under the engine `rigid`."""
    controller = find_controller(f"sb3:{file}")
    episodes = run_episodes(find_scenario("es1"), controller, SEEDS[:n_worlds])
    return float(np.mean([episode.round_trips for episode in episodes]))


def main(arguments: Sequence[str] | None = None) -> list[float]:
    """Train, and tell the score and the wall clock after each interval."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--device", default="cuda", help="cuda or cpu")
    parser.add_argument("--worlds", type=int, default=1024)
    parser.add_argument("--robot-steps", type=int, default=1_000_000_000, metavar="N")
    parser.add_argument("--intervals", type=int, default=10)
    parser.add_argument("--shaping", type=float, default=TERMS.shaping)
    parser.add_argument("--scored", type=int, default=30, help="worlds of a score, at most 30")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path("runs/train_on_gpu"))
    chosen = parser.parse_args(arguments)
    chosen.out.mkdir(parents=True, exist_ok=True)
    file = chosen.out / "model.zip"
    torch.set_num_threads(1)  # quicker on a CPU for networks this small
    learner = make_learner(chosen.device, chosen.worlds, chosen.shaping, chosen.seed)
    decisions = -(-chosen.robot_steps // (TERMS.decision_period * chosen.intervals))
    scores, training_s, begin = [], 0.0, time.perf_counter()
    for interval in range(chosen.intervals):
        start = time.perf_counter()
        learner.learn(decisions, TERMS.learning_rate, None if interval else chosen.seed)
        training_s += time.perf_counter() - start
        save(learner.policy, file)
        scores.append(round_trips(file, chosen.scored))
        steps = learner.n_decisions * TERMS.decision_period
        print(
            f"{steps:14,} robot-steps, {training_s:6.1f} s of training,"
            f" {time.perf_counter() - begin:6.1f} s in all: {scores[-1]:6.1f} round trips",
            flush=True,
        )
    print(f"test it: swarm-forage evaluate es1 ssgikf sb3:{file}")
    return scores


if __name__ == "__main__":
    main()
