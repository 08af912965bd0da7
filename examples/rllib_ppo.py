"""RLlib's PPO (new API stack), from scratch: one policy learns how all robots steer.

    make .venv-rllib/.ready              # ray pins another gymnasium: an environment of its own
    .venv-rllib/bin/python examples/rllib_ppo.py

All worlds of an env runner are one block of arrays (`training.rllib_env`). A robot earns 1 for
each round trip, and nothing else.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import ray
import torch
from numpy.typing import NDArray
from ray.rllib.algorithms.ppo import PPOConfig
from ray.rllib.core.rl_module.default_model_config import DefaultModelConfig
from ray.rllib.core.rl_module.multi_rl_module import MultiRLModuleSpec
from ray.rllib.core.rl_module.rl_module import RLModule, RLModuleSpec

from baselines.evaluation.episode import run_episodes
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.scenarios import find_scenario
from training.policy_controller import policy_controller
from training.rllib_env import SwarmEnvRunner, SwarmMultiAgentEnv, save_policies

PERIOD = 10
"""Ticks (0.1 s) for which an action is held."""

DISCOUNT = 0.99
"""Of a decision."""

NETWORKS = DefaultModelConfig(
    fcnet_hiddens=[64, 64],
    fcnet_activation="tanh",
    head_fcnet_hiddens=[],
    vf_share_layers=False,
)

HELD_OUT = range(1000, 10**6)
"""Seeds of the episodes that the trained policy is judged by."""


def configure(seed: int, worlds: int, decisions: int, **options: Any) -> PPOConfig:
    """PPO with one module for all robots, on so many decisions of each in an iteration.

    The `options` are keywords of `parallel_env`.
    """
    terms = {"decision_period": PERIOD, **options}
    return (
        PPOConfig()
        .environment(SwarmMultiAgentEnv, env_config=terms, disable_env_checking=True)
        .env_runners(
            env_runner_cls=SwarmEnvRunner,  # all worlds at once
            num_env_runners=0,  # in this process; each runner more is a process more
            num_envs_per_env_runner=worlds,
        )
        .multi_agent(policies={"robot"}, policy_mapping_fn=lambda agent, *_, **__: "robot")
        .rl_module(
            rl_module_spec=MultiRLModuleSpec(
                rl_module_specs={"robot": RLModuleSpec(model_config=NETWORKS)}
            )
        )
        .training(
            gamma=DISCOUNT,
            lambda_=0.95,
            lr=3e-4,
            train_batch_size_per_learner=worlds * decisions,  # decisions of whole swarms
            minibatch_size=min(1024, worlds * decisions),  # decisions of single robots
            num_epochs=10,
            use_kl_loss=False,
        )
        .debugging(seed=seed)
    )


def train(algorithm: Any, robot_steps: int) -> None:
    """Train for so many ticks of single robots, and print how many round trips they make."""
    env, done = algorithm.env_runner.env.env, 0
    while done < robot_steps:
        results = algorithm.train()["env_runners"]
        done = int(results["num_env_steps_sampled_lifetime"]) * len(env.learners) * PERIOD
        trips = env.world.robots["round_trips"].sum(axis=1).mean()
        share = env.episodes.share_gone[0]
        print(
            f"{done:10,} robot-steps: {trips:6.1f} round trips in {share:4.0%} of an episode",
            flush=True,
        )


def compare(module: RLModule, episodes: int) -> dict[str, float]:
    """Print the mean round trips of an episode of the policy, and of some to compare with."""
    rng = np.random.default_rng(0)

    def wander(observed: NDArray[np.float32]) -> NDArray[np.float32]:
        return rng.uniform(-1.0, 1.0, (len(observed), 2)).astype(np.float32)

    @torch.no_grad()
    def gaussian(observed: NDArray[np.float32]) -> tuple[NDArray[np.float32], ...]:
        output = module.forward_inference({"obs": torch.from_numpy(observed)})
        mean, log_deviation = output["action_dist_inputs"].chunk(2, dim=1)
        return mean.numpy(), log_deviation.exp().numpy()

    def steer(observed: NDArray[np.float32]) -> NDArray[np.float32]:
        mean, _ = gaussian(observed)
        return mean

    def stochastic(observed: NDArray[np.float32]) -> NDArray[np.float32]:
        mean, deviation = gaussian(observed)
        return rng.normal(mean, deviation).astype(np.float32)

    controllers = {
        "random": policy_controller(wander, decision_period=PERIOD),
        "ssgikf, hand-written": find_controller("ssgikf"),
        "the trained policy": policy_controller(steer, decision_period=PERIOD),
        "the same, stochastic": policy_controller(stochastic, decision_period=PERIOD),
    }
    trips = {}
    for name, controller in controllers.items():
        seen = run_episodes(find_scenario("es1"), controller, HELD_OUT[:episodes])
        trips[name] = float(np.mean([episode.round_trips for episode in seen]))
        print(f"{name:>22}: {trips[name]:6.1f} round trips an episode")
    return trips


def main(arguments: Sequence[str] | None = None) -> None:
    """Train, keep a checkpoint, and compare on episodes that it was not trained on."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--robot-steps", type=int, default=4_000_000, metavar="N")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--episodes", type=int, default=10, help="held-out ones")
    parser.add_argument("--out", type=Path, default=Path("runs/rllib_ppo"))
    chosen = parser.parse_args(arguments)
    torch.set_num_threads(1)  # quicker for networks this small
    ray.init(num_cpus=1, include_dashboard=False, ignore_reinit_error=True)
    algorithm = configure(chosen.seed, worlds=8, decisions=128).build_algo()
    train(algorithm, chosen.robot_steps)
    algorithm.save_to_path(chosen.out.resolve())
    (file,) = save_policies(algorithm, chosen.out)
    print(f"kept: {file}; swarm-forage evaluate es1 torchscript:{file} runs it")
    compare(algorithm.get_module("robot"), chosen.episodes)
    algorithm.stop()
    ray.shutdown()


if __name__ == "__main__":
    main()
