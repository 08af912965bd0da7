"""Worlds and a network on one GPU: no number crosses to the CPU.

    pip install 'swarm-forage[cuda]' torch
    python examples/torch_on_gpu.py --worlds 4096 --steps 1000

The network is a plain one with random weights: put your learner in its place. What is printed is
the mean reward of a robot, and how many robot-steps a second your GPU made.
"""

import argparse
import time

import torch

from swarm_forage_env import array_env


def main() -> None:
    """Run worlds under a network, all on the GPU."""
    parser = argparse.ArgumentParser(description="Worlds and a network on one GPU.")
    parser.add_argument("--worlds", type=int, default=4096)
    parser.add_argument("--steps", type=int, default=1000, help="decisions, of ten ticks each")
    wanted = parser.parse_args()
    env = array_env("es1", device="cuda", n_worlds=wanted.worlds, physics="kinematic", stagger=True)
    n_seen, n_given = len(env.observation_layout), len(env.action_layout)
    policy = torch.nn.Sequential(
        torch.nn.Linear(n_seen, 64), torch.nn.Tanh(), torch.nn.Linear(64, n_given), torch.nn.Tanh()
    ).to("cuda")
    seen, _ = env.reset(seed=0)
    outputs = None  # the arrays of a step, which the next one overwrites
    total = torch.zeros((), device="cuda", dtype=torch.float64)
    start = time.perf_counter()
    for _ in range(wanted.steps):
        with torch.no_grad():
            actions = policy(torch.as_tensor(seen, device="cuda"))
        step = env.step_and_reset(actions, outputs)
        seen, outputs = step.observations, step.outputs
        total += torch.as_tensor(step.rewards, device="cuda").mean()
    env.check()  # that every action was within its bounds
    mean = float(total)  # waits for the GPU
    seconds = time.perf_counter() - start
    n_robot_steps = wanted.worlds * len(env.learners) * wanted.steps * env.config.period
    print(f"{mean:.3f} rewards a robot; {n_robot_steps / seconds / 1e6:.1f} M robot-steps/s")


if __name__ == "__main__":
    main()
