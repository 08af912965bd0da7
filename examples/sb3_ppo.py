"""Stable-baselines3's PPO on a swarm: one policy learns to steer all robots of eight worlds.

python examples/sb3_ppo.py [robot steps]
"""

import sys

from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import VecMonitor

from training.vec_env import SwarmVecEnv

PERIOD = 5
"""Ticks for which an action is held."""


def main(robot_steps: int) -> PPO:
    """Train for so many ticks of single robots."""
    env = SwarmVecEnv(
        "es1",
        n_worlds=8,
        learn="motion",
        controller="ssgiff",
        decision_period=PERIOD,
        shaping=1.0,
        discount=0.995,
        physics="kinematic",
    )
    model = PPO(
        "MlpPolicy",
        VecMonitor(env),
        gamma=0.995,
        n_steps=256,
        batch_size=2048,
        seed=0,
        device="cpu",
        verbose=1,
    )
    return model.learn(robot_steps // PERIOD)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 2_000_000)
