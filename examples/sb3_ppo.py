"""Stable-baselines3's PPO on a swarm, from scratch: one policy learns how all robots steer.

    pip install 'swarm-forage[train]'
    python examples/sb3_ppo.py                                  # two minutes on two cores
    swarm-forage evaluate es1 ssgikf sb3:runs/sb3_ppo/model.zip
    swarm-forage watch es1 sb3:runs/sb3_ppo/model.zip

Every robot of every world is an environment to SB3, all under one policy, with SB3's defaults but
for the sizes of rollout and batch, and a narrower start. A robot earns 1 for each round trip; the
shaping, which leaves the best policies as they are, tells it before the first one where it is
going. Training acts by chance, a policy that is used does not, and may be far worse: so it is tried
without chance eight times, in episodes of their own, and the best one is kept.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback, EvalCallback

from baselines.evaluation.episode import run_episodes
from swarm_forage_env.controllers import find_controller
from training.policy_controller import policy_controller
from training.vec_env import SwarmVecEnv

PERIOD = 10
"""Ticks (0.1 s) for which an action is held."""

DISCOUNT = 0.99
"""Of a decision: SB3's default, and so that of the shaping."""

NARROW = -0.7
"""Logarithm of the first deviation of the actions, which lie in [-1, 1]: with a wider one robots
come to search by their noise, and are lost without it."""

ROLLOUT = 128
"""Decisions of a robot between two updates."""

TRIALS, TRIED_FROM = 8, 2000
"""How often the policy is tried while it trains, and the seed of the episodes of these trials."""

HELD_OUT = range(1000, 1010)
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


def train(robot_steps: int, seed: int, out: Path) -> Path:
    """Train for so many ticks of single robots, and return the file of the best policy tried."""
    torch.set_num_threads(1)  # quicker for networks this small
    env = SwarmVecEnv(
        "es1",
        n_worlds=8,
        decision_period=PERIOD,
        shaping=1.0,
        discount=DISCOUNT,
        physics="kinematic",
    )
    model = PPO(
        "MlpPolicy",
        env,
        gamma=DISCOUNT,
        n_steps=ROLLOUT,
        batch_size=1024,
        policy_kwargs={"log_std_init": NARROW},
        seed=seed,
        device="cpu",
    )
    tried_in = SwarmVecEnv(
        "es1", n_worlds=4, decision_period=PERIOD, physics="kinematic", seed=TRIED_FROM
    )
    trials = EvalCallback(
        tried_in,
        n_eval_episodes=tried_in.num_envs,
        eval_freq=max(ROLLOUT, robot_steps // PERIOD // env.num_envs // TRIALS),
        best_model_save_path=str(out),
        verbose=0,
        warn=False,
    )
    model.learn(robot_steps // PERIOD, callback=[RoundTrips(), trials])
    return (out / "best_model.zip").replace(out / "model.zip")


def compare(file: Path, episodes: int) -> dict[str, float]:
    """Print the mean round trips of an episode of the saved policy, and of two to compare with."""
    rng = np.random.default_rng(0)

    def wander(observed: NDArray[np.float32]) -> NDArray[np.float32]:
        return rng.uniform(-1.0, 1.0, (len(observed), 2)).astype(np.float32)

    controllers = {
        "random": policy_controller(wander, decision_period=PERIOD),
        "ssgikf, hand-written": find_controller("ssgikf"),
        "the trained policy": find_controller(f"sb3:{file}"),
    }
    env = SwarmVecEnv("es1", n_worlds=1)
    found = {}
    for name, controller in controllers.items():
        seen = run_episodes(env.scenario, controller, HELD_OUT[:episodes])
        found[name] = float(np.mean([episode.round_trips for episode in seen]))
        print(f"{name:>22}: {found[name]:6.1f} round trips an episode")
    return found


def main(arguments: Sequence[str] | None = None) -> dict[str, float]:
    """Train, save the model, and compare it on episodes that it was not trained on."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--robot-steps", type=int, default=4_000_000, metavar="N")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--episodes", type=int, default=10, help="held-out ones, at most 10")
    parser.add_argument("--out", type=Path, default=Path("runs/sb3_ppo"))
    chosen = parser.parse_args(arguments)
    chosen.out.mkdir(parents=True, exist_ok=True)
    file = train(chosen.robot_steps, chosen.seed, chosen.out)
    found = compare(file, chosen.episodes)
    print(f"test it:  swarm-forage evaluate es1 ssgikf sb3:{file}")
    print(f"watch it: swarm-forage watch es1 sb3:{file}")
    return found


if __name__ == "__main__":
    main()
