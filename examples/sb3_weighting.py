"""Stable-baselines3's PPO on the weighting, from exchange to exchange: whom a robot believes.

    pip install 'swarm-forage[train]'
    python examples/sb3_weighting.py                            # some minutes on two cores
    swarm-forage evaluate es1 ssgikf sb3:runs/sb3_weighting/model.zip

A weight counts in 0.35 % of the ticks of es1, so that a learner that acts in every tick learns
nothing. With `step_on="exchange"` every step of a world ends with an exchange of one of its robots.
The rest, the motion too, is hand-written. At the end the policy is set against `ssgikf`, whose rule
it takes the place of, and against a weight of one half, from which it starts.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.stats import mannwhitneyu
from stable_baselines3 import PPO

from baselines.evaluation.episode import run_episodes
from swarm_forage_env.controllers import find_controller
from training.policy_controller import policy_controller
from training.vec_env import SwarmVecEnv

DISCOUNT = 0.99
"""Of a step, in which a world has one exchange: about 3 s."""

HELD_OUT = range(1000, 1030)
"""Seeds of the episodes that the trained policy is judged by."""


def train(steps: int, seed: int) -> PPO:
    """Train for so many exchanges of each of eight worlds."""
    torch.set_num_threads(1)  # quicker for networks this small
    env = SwarmVecEnv(
        "es1",
        n_worlds=8,
        learn="weighting",
        step_on="exchange",
        shaping=1.0,
        discount=DISCOUNT,
        physics="kinematic",
        stagger=True,
    )
    model = PPO(
        "MlpPolicy",
        env,
        gamma=DISCOUNT,
        n_steps=256,
        batch_size=2560,
        policy_kwargs={"log_std_init": -0.7},
        seed=seed,
        device="cpu",
    )
    return model.learn(steps * env.num_envs)


def compare(file: Path, episodes: int) -> dict[str, float]:
    """Print the round trips of an episode under the policy, and under two to compare with."""

    def half(observed: NDArray[np.float32]) -> NDArray[np.float32]:
        return np.zeros((len(observed), 2), np.float32)

    controllers = {
        "ssgikf, hand-written": find_controller("ssgikf"),
        "one half": policy_controller(half, learn="weighting", decision_period=1),
        "the trained policy": find_controller(f"sb3:{file}"),
    }
    scenario = SwarmVecEnv("es1", n_worlds=1).scenario
    trips = {
        name: [each.round_trips for each in run_episodes(scenario, own, HELD_OUT[:episodes])]
        for name, own in controllers.items()
    }
    reference, *_ = trips.values()
    for name, own in trips.items():
        p = mannwhitneyu(own, reference).pvalue
        print(f"{name:>22}: {np.mean(own):6.1f} round trips an episode, p against ssgikf {p:.2g}")
    return {name: float(np.mean(own)) for name, own in trips.items()}


def main(arguments: Sequence[str] | None = None) -> dict[str, float]:
    """Train, save the model, and compare it on episodes that it was not trained on."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--steps", type=int, default=12_000, help="exchanges of each world")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--episodes", type=int, default=30, help="held-out ones, at most 30")
    parser.add_argument("--out", type=Path, default=Path("runs/sb3_weighting"))
    chosen = parser.parse_args(arguments)
    chosen.out.mkdir(parents=True, exist_ok=True)
    file = chosen.out / "model.zip"
    train(chosen.steps, chosen.seed).save(file)
    return compare(file, chosen.episodes)


if __name__ == "__main__":
    main()
