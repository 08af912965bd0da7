"""TorchRL: frames per second beside PettingZooWrapper, and what training by PPO spends them on.

    .venv-torchrl/bin/python examples/torchrl_speed.py

A frame is a decision of one swarm of es1, held for one tick. Actions are random, all that TorchRL
does with a frame is counted, and time is that of the processor, on one core. The learner's share
is of `torchrl_mappo.py --scenario es1 --ippo`: all time but that of as many frames with random
actions, of five ticks each.
"""

import argparse
import time
from collections.abc import Sequence

import torch
from torchrl.envs import EnvBase
from torchrl.envs.libs.pettingzoo import PettingZooWrapper
from torchrl_mappo import N_WORLDS, SCENARIOS, TERMS, train

import baselines.controllers  # noqa: F401 runs the layers that are not learned
from swarm_forage_env import parallel_env
from training.torchrl_env import SwarmTorchEnv

BLOCKS = (4, 16, 64)
"""Worlds side by side."""


def frames_per_second(envs: dict[str, EnvBase], steps: int, repeats: int) -> dict[str, float]:
    """The most that each reaches, in turn, so that a busy moment of the machine hits all."""
    found = dict.fromkeys(envs, 0.0)
    for _ in range(repeats + 1):  # the first time compiles
        for name, env in envs.items():
            begun = time.process_time()
            seen = env.rollout(steps, break_when_any_done=False)
            found[name] = max(found[name], seen.numel() / (time.process_time() - begun))
    return found


def compare(steps: int, repeats: int) -> None:
    """Print the speed of each block, and how many times that of the wrapper it is."""
    options = {"scenario": "es1", "physics": "kinematic", "decision_period": 1}
    wrapper = PettingZooWrapper(parallel_env(**options), return_state=True)
    blocks = {f"{n} worlds": SwarmTorchEnv(n_worlds=n, **options) for n in BLOCKS}
    found = frames_per_second({"PettingZooWrapper": wrapper, **blocks}, steps, repeats)
    slowest = found["PettingZooWrapper"]
    print(f"{'es1, random actions':<24}{'frames/s':>10}{'times':>8}")
    for name, speed in found.items():
        print(f"{name:<24}{speed:>10.0f}{speed / slowest:>8.1f}")


def learners_share(iterations: int, steps: int, repeats: int) -> None:
    """Print how the time of training is spent."""
    options = {**TERMS, **SCENARIOS["es1"]}
    env = SwarmTorchEnv(n_worlds=N_WORLDS, **options)
    speed = frames_per_second({"env": env}, steps, repeats)["env"]
    train(1, steps=8, is_ippo=True, **options)
    begun = time.process_time()
    train(iterations, is_ippo=True, **options)
    spent = time.process_time() - begun
    frames = iterations * 128 * N_WORLDS
    share = 1.0 - frames / speed / spent
    print(f"\nIPPO, {N_WORLDS} worlds of es1: {frames / spent:.0f} frames/s, of which the")
    print(f"environment alone makes {speed:.0f}: {share:.0%} of the time is the learner's")


def main(arguments: Sequence[str] | None = None) -> None:
    """Read the command line, and measure."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--steps", type=int, default=100)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--iterations", type=int, default=8, help="of training")
    chosen = parser.parse_args(arguments)
    torch.set_num_threads(1)
    compare(chosen.steps, chosen.repeats)
    learners_share(chosen.iterations, chosen.steps, chosen.repeats)


if __name__ == "__main__":
    main()
