"""RLlib's PPO (new API stack): one policy for all robots.

    make .venv-rllib/.ready              # ray pins another gymnasium: an environment of its own
    .venv-rllib/bin/python examples/rllib_ppo.py --scenario es1 --learn weighting --iterations 100

RLlib keeps the robots in a set, whose order differs from process to process: one seed gives one
policy only with `PYTHONHASHSEED=0` in front of the command.

A weighting is learned while hand-written motion brings in the round trips. A motion must first find
the areas, which wheel speeds drawn around zero never do: see `cleanrl_ppo.py` for a start.

Observations are in SI with bounds that are proven but kilometres wide: never scale by them. A
connector squeezes them with symlog, on the way to the module.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import ray
from numpy.typing import NDArray
from ray.rllib.algorithms.ppo import PPOConfig
from ray.rllib.connectors.env_to_module.observation_preprocessor import (
    SingleAgentObservationPreprocessor,
)
from ray.rllib.core.rl_module.multi_rl_module import MultiRLModuleSpec
from ray.rllib.core.rl_module.rl_module import RLModuleSpec
from ray.rllib.env.wrappers.pettingzoo_env import ParallelPettingZooEnv
from ray.tune.registry import register_env

from swarm_forage_env import parallel_env

DISCOUNT = 0.999
"""Of a decision: a tick (0.1 s) for a weighting."""


def symlog(x: NDArray[np.float32]) -> NDArray[np.float32]:
    """sign(x) log(1 + |x|): near x for small numbers, slow for large ones."""
    return np.sign(x) * np.log1p(np.abs(x))


class Symlog(SingleAgentObservationPreprocessor):
    """Squeezes what a robot observes before its policy sees it."""

    def recompute_output_observation_space(
        self, input_observation_space: gym.Space, input_action_space: gym.Space
    ) -> gym.Space:
        """The squeezed spaces of all robots."""
        return gym.spaces.Dict(
            {
                robot: gym.spaces.Box(symlog(box.low), symlog(box.high), dtype=np.float32)
                for robot, box in input_observation_space.spaces.items()
            }
        )

    def preprocess(self, observation: NDArray[np.float32], episode: Any) -> NDArray[np.float32]:
        """One robot's observation, squeezed."""
        return symlog(observation)


def configure(seed: int, steps: int, **options: Any) -> PPOConfig:
    """PPO with one module, to which every robot maps; `options` are those of `parallel_env`."""
    register_env("swarm_forage", lambda terms: ParallelPettingZooEnv(parallel_env(**terms)))
    return (
        PPOConfig()
        .environment("swarm_forage", env_config={"discount": DISCOUNT, **options})
        .env_runners(
            num_env_runners=0,  # in this process; each runner more is a process more
            env_to_module_connector=lambda env, spaces, device: Symlog(),
        )
        .multi_agent(policies={"robot"}, policy_mapping_fn=lambda agent, *_, **__: "robot")
        .rl_module(rl_module_spec=MultiRLModuleSpec(rl_module_specs={"robot": RLModuleSpec()}))
        .training(
            gamma=DISCOUNT,
            lambda_=0.95,
            lr=3e-4,
            train_batch_size_per_learner=steps,  # decisions of the whole swarm
            minibatch_size=max(steps // 2, 1),  # of single robots
            num_epochs=4,
        )
        .debugging(seed=seed)
    )


def train(iterations: int, seed: int, steps: int, out: Path, **options: Any) -> list[Any]:
    """Train and keep a checkpoint in `out`; the results of all iterations."""
    ray.init(num_cpus=1, include_dashboard=False, ignore_reinit_error=True)
    algorithm = configure(seed, steps, **options).build_algo()
    results = []
    for iteration in range(1, iterations + 1):
        results.append(algorithm.train())
        score = results[-1]["env_runners"].get("episode_return_mean", float("nan"))
        print(f"iteration {iteration}: return of the swarm {score:.2f}", flush=True)
    algorithm.save_to_path(out.resolve())
    algorithm.stop()
    ray.shutdown()
    return results


def main(arguments: Sequence[str] | None = None) -> None:
    """Read the command line and train."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--scenario", default="es1")
    parser.add_argument("--learn", default="weighting", choices=["motion", "weighting", "both"])
    parser.add_argument("--iterations", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path("runs/rllib_ppo"))
    chosen = parser.parse_args(arguments)
    options = {"scenario": chosen.scenario, "learn": chosen.learn, "max_cycles": 9000}
    if chosen.learn == "motion":
        options |= {"decision_period": 10, "max_cycles": 900, "shaping": 1.0}
    train(chosen.iterations, chosen.seed, 2048, chosen.out, **options)


if __name__ == "__main__":
    main()
