"""Stable-baselines3's PPO on a swarm: one policy learns to correct how all robots steer.

    python examples/sb3_ppo.py --robot-steps 2000000

The policy's wheels are added to those of subsumption (`residual`), so that robots forage from the
first step on; wheels drawn around zero alone would never bring one to an area.
"""

import argparse

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
        residual=True,
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
        policy_kwargs={"log_std_init": -2.0},
        seed=0,
        device="cpu",
        verbose=1,
    )
    return model.learn(robot_steps // PERIOD)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--robot-steps", type=int, default=2_000_000, metavar="N")
    main(parser.parse_args().robot_steps)
