"""BenchMARL: a task of its own, for any of its algorithms.

    make .venv-torchrl/.ready            # the tested set, with torchrl and benchmarl beside
    .venv-torchrl/bin/python examples/benchmarl_task.py --task ES1_WEIGHTING --algorithm mappo

A task is a name in an enum and a dictionary of `parallel_env`'s keywords. BenchMARL gives every
world of a run the same seed, and so the same episodes; here each draws its own.

A weighting is learned while hand-written motion brings in the round trips. A motion must first find
the areas, which wheel speeds drawn around zero never do: see `cleanrl_ppo.py` for a start.

Observations and the state are in SI with bounds that are proven but kilometres wide: never scale
by them. A transform squeezes both with symlog.
"""

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import torch
from benchmarl.algorithms import IppoConfig, MappoConfig
from benchmarl.environments import Task
from benchmarl.environments.pettingzoo.common import PettingZooClass
from benchmarl.experiment import Experiment, ExperimentConfig
from benchmarl.models.mlp import MlpConfig
from torch import Tensor
from torchrl.envs import EnvBase, Transform, UnaryTransform
from torchrl.envs.libs.pettingzoo import PettingZooWrapper

from swarm_forage_env import parallel_env

ALGORITHMS = {"ippo": IppoConfig, "mappo": MappoConfig}
DISCOUNT = 0.999
"""Of a decision: a tick (0.1 s) for a weighting."""


def symlog(x: Tensor) -> Tensor:
    """sign(x) log(1 + |x|): near x for small numbers, slow for large ones."""
    return torch.sign(x) * torch.log1p(torch.abs(x))


class SwarmForageClass(PettingZooClass):
    """Makes the worlds of a task and tells BenchMARL what they can do."""

    def get_env_fun(
        self, num_envs: int, continuous_actions: bool, seed: int | None, device: Any
    ) -> Callable[[], EnvBase]:
        """A function that makes one world; each call draws a seed after the experiment's."""
        return lambda: PettingZooWrapper(
            parallel_env(**self.config),
            return_state=True,
            seed=int(torch.randint(2**31, ())),
            device=device,
        )

    def get_env_transforms(self, env: EnvBase) -> list[Transform]:
        """Squeezes what the robots observe and what the critic knows."""
        squeezed = [("epuck", "observation"), "state"]
        return [UnaryTransform(squeezed, squeezed, fn=symlog)]

    def supports_continuous_actions(self) -> bool:
        """Wheel speeds and weights are numbers."""
        return True

    def supports_discrete_actions(self) -> bool:
        """There are none."""
        return False

    def has_state(self) -> bool:
        """`env.state()`: true poses and all beliefs, for centralised critics."""
        return True

    def has_render(self, env: EnvBase) -> bool:
        """Nothing is drawn."""
        return False

    def max_steps(self, env: EnvBase) -> int:
        """Decisions in an episode."""
        return int(self.config["max_cycles"])

    @staticmethod
    def env_name() -> str:
        """The name under which results are filed."""
        return "swarm_forage"


class SwarmForageTask(Task):
    """The tasks by name; `get_task(config=...)` takes other keywords of `parallel_env`."""

    ES1_MOTION = None
    ES1_WEIGHTING = None

    @staticmethod
    def associated_class() -> type[SwarmForageClass]:
        """What makes the worlds."""
        return SwarmForageClass


CONFIGS: dict[str, dict[str, Any]] = {
    "ES1_MOTION": {
        "scenario": "es1",
        "learn": "motion",
        "decision_period": 10,
        "shaping": 1.0,
        "discount": DISCOUNT,
        "max_cycles": 900,
    },
    "ES1_WEIGHTING": {"scenario": "es1", "learn": "weighting", "max_cycles": 9000},
}


def settings(iterations: int, steps: int, worlds: int, out: Path) -> ExperimentConfig:
    """How to train, on the processor, without evaluation or logs of others."""
    config = ExperimentConfig.get_from_yaml()
    config.gamma = DISCOUNT
    config.lr = 3e-4
    config.max_n_iters, config.max_n_frames = iterations, None
    config.on_policy_collected_frames_per_batch = steps
    config.on_policy_n_envs_per_worker = worlds
    config.on_policy_n_minibatch_iters = 4
    config.on_policy_minibatch_size = max(steps // 8, 1)
    config.evaluation, config.render = False, False
    config.loggers, config.save_folder = ["csv"], str(out)
    return config


def train(  # noqa: PLR0913 the numbers of an experiment
    task: str,
    algorithm: str,
    config: dict[str, Any],
    seed: int = 1,
    iterations: int = 100,
    steps: int = 4096,
    worlds: int = 4,
    out: Path = Path("runs/benchmarl"),
) -> Experiment:
    """Train one policy for all robots; BenchMARL's own logs go to `out`."""
    out.mkdir(parents=True, exist_ok=True)
    experiment = Experiment(
        task=SwarmForageTask[task].get_task(config=config),
        algorithm_config=ALGORITHMS[algorithm].get_from_yaml(),
        model_config=MlpConfig.get_from_yaml(),
        critic_model_config=MlpConfig.get_from_yaml(),
        seed=seed,
        config=settings(iterations, steps, worlds, out.resolve()),
    )
    experiment.run()
    return experiment


def main(arguments: Sequence[str] | None = None) -> None:
    """Read the command line and train."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--task", default="ES1_WEIGHTING", choices=sorted(CONFIGS))
    parser.add_argument("--algorithm", default="mappo", choices=sorted(ALGORITHMS))
    parser.add_argument("--iterations", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    chosen = parser.parse_args(arguments)
    train(chosen.task, chosen.algorithm, CONFIGS[chosen.task], chosen.seed, chosen.iterations)


if __name__ == "__main__":
    main()
