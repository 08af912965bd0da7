"""Stable-baselines3's PPO on a swarm, from scratch: one policy learns how all robots steer.

    pip install 'swarm-forage[train]'
    python examples/sb3_ppo.py                                  # a minute on two cores
    swarm-forage evaluate es1 ssgikf sb3:runs/sb3_ppo/model.zip
    swarm-forage watch es1 sb3:runs/sb3_ppo/model.zip

Every robot of every world is an environment to SB3, all under one policy, with SB3's defaults but
for the sizes of rollout and batch. A robot earns 1 for each round trip, and nothing else. Worlds
start one after the other (`stagger`), so that a rollout holds all parts of an episode.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback

from baselines.evaluation.episode import run_episodes
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.scenarios import find_scenario
from training.policy_controller import policy_controller
from training.vec_env import SwarmVecEnv

PERIOD = 10
"""Ticks (0.1 s) for which an action is held: the default of a motion."""

ROLLOUT, BATCH = 128, 1024
"""Decisions of a robot between two updates, and of all robots in one gradient step."""

HELD_OUT = range(1000, 10**6)
"""Seeds of the episodes that the trained policy is judged by."""


class RoundTrips(BaseCallback):
    """Prints after each rollout how many round trips an episode at its rate would come to."""

    def _on_rollout_start(self) -> None:
        self.trips, self.begin = 0.0, self.num_timesteps

    def _on_step(self) -> bool:
        self.trips += sum(info["unshaped_reward"] for info in self.locals["infos"])
        return True

    def _on_rollout_end(self) -> None:
        (episode,) = set(self.training_env.get_attr("max_cycles"))
        robots = len(self.training_env.get_attr("env", 0)[0].learners)
        rate = self.trips / (self.num_timesteps - self.begin) * episode * robots
        steps = self.num_timesteps * PERIOD
        print(f"{steps:10,} robot-steps: {rate:6.1f} round trips an episode", flush=True)


def train(robot_steps: int, seed: int, file: Path) -> None:
    """Train for so many ticks of single robots, and save the model."""
    torch.set_num_threads(1)  # quicker for networks this small
    env = SwarmVecEnv("es1", n_worlds=8, stagger=True)
    model = PPO("MlpPolicy", env, n_steps=ROLLOUT, batch_size=BATCH, seed=seed, device="cpu")
    model.learn(robot_steps // PERIOD, callback=RoundTrips())
    model.save(file)


def compare(file: Path, episodes: int) -> dict[str, float]:
    """Print the mean round trips of an episode of the saved policy, and of some to compare with."""
    rng = np.random.default_rng(0)

    def wander(observed: NDArray[np.float32]) -> NDArray[np.float32]:
        return rng.uniform(-1.0, 1.0, (len(observed), 2)).astype(np.float32)

    controllers = {
        "random": policy_controller(wander),
        "ssgikf, hand-written": find_controller("ssgikf"),
        "the trained policy": find_controller(f"sb3:{file}"),
        "the same, stochastic": find_controller(f"sb3:{file},chance=true"),
    }
    trips = {}
    for name, controller in controllers.items():
        seen = run_episodes(find_scenario("es1"), controller, HELD_OUT[:episodes])
        trips[name] = float(np.mean([episode.round_trips for episode in seen]))
        print(f"{name:>22}: {trips[name]:6.1f} round trips an episode")
    return trips


def main(arguments: Sequence[str] | None = None) -> dict[str, float]:
    """Train, save the model, and compare it on episodes that it was not trained on."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--robot-steps", type=int, default=6_000_000, metavar="N")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--episodes", type=int, default=10, help="held-out ones")
    parser.add_argument("--out", type=Path, default=Path("runs/sb3_ppo"))
    chosen = parser.parse_args(arguments)
    chosen.out.mkdir(parents=True, exist_ok=True)
    file = chosen.out / "model.zip"
    train(chosen.robot_steps, chosen.seed, file)
    trips = compare(file, chosen.episodes)
    print(f"test it:  swarm-forage evaluate es1 ssgikf sb3:{file}")
    print(f"watch it: swarm-forage watch es1 sb3:{file}")
    return trips


if __name__ == "__main__":
    main()
