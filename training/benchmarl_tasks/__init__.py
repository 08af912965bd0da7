"""BenchMARL's tasks: a name of the enum, and a file of `parallel_env`'s keywords, for each.

    python -m training.benchmarl_tasks task=swarm_forage/near algorithm=mappo

A file in `conf/task/swarm_forage` is a task of the enum: another one is another file.
"""

from collections.abc import Callable
from functools import cached_property, partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import torch
import yaml
from benchmarl.environments import Task, TaskClass, task_config_registry
from benchmarl.experiment import Callback, Experiment, ExperimentConfig
from tensordict import TensorDictBase
from torch import Tensor
from torchrl.data import Composite
from torchrl.envs import EnvBase, RewardScaling, RewardSum, Transform
from torchrl.record import CSVLogger

import baselines.controllers  # noqa: F401 runs the layers that are not learned
from swarm_forage_env.envs.config import EnvConfig
from swarm_forage_env.envs.render import Frame
from swarm_forage_env.errors import UnknownNameError
from swarm_forage_env.extras import EXTRAS
from swarm_forage_env.rendering.video import Video
from training.torchrl_env import SwarmTorchEnv, save_policy

CONF = Path(__file__).parent / "conf"

FOLDER = CONF / "task" / "swarm_forage"

MAX_FRAMES = 2000
"""Steps of an episode of which a video is made: BenchMARL holds all of its frames in memory."""


class SwarmForageClass(TaskClass):  # type: ignore[misc]
    """Tells BenchMARL how to make a task, and what it can do.

    `config` holds keywords of `parallel_env`, without the card of a rung (`training.ladder`), and
    `reward_scale`, a factor of the rewards: values of 0.01, as those of round trips, drown in the
    noise of a value network's updates. `discrete` counts only for algorithms of discrete actions,
    which have the default choices without it.
    """

    def __init__(self, name: str, config: dict[str, Any]) -> None:
        own = {key: value for key, value in config.items() if key != "card"}
        self._reward_scale = float(own.pop("reward_scale", 1.0))
        super().__init__(name, own)

    def get_env_fun(
        self, num_envs: int, continuous_actions: bool, seed: int | None, device: torch.device | str
    ) -> Callable[[], EnvBase]:
        """A function that makes one block of `num_envs` worlds.

        BenchMARL gives one seed to the worlds of training and of evaluation. Here each block
        draws its own after it, so that no policy is evaluated on episodes of its training.
        """
        discrete = False if continuous_actions else self.config.get("discrete") or True
        options = {**self.config, "discrete": discrete, "n_worlds": num_envs, "device": device}
        return lambda: SwarmTorchEnv(**options, seed=int(torch.randint(2**31, ())))

    def supports_continuous_actions(self) -> bool:
        """Steering and weights as numbers."""
        return True

    def supports_discrete_actions(self) -> bool:
        """Steering and weights as choices among a few."""
        return True

    def has_render(self, env: EnvBase) -> bool:
        """The task can be drawn, its episodes are short, and the extra `render` is installed."""
        has_extra = all(find_spec(name) for name in EXTRAS["render"])
        return has_extra and env.has_render and env.max_cycles <= MAX_FRAMES

    def max_steps(self, env: EnvBase) -> int:
        """Decisions in an episode."""
        return int(env.max_cycles)

    def group_map(self, env: EnvBase) -> dict[str, list[str]]:
        """One group of all robots that learn."""
        return dict(env.group_map)

    def observation_spec(self, env: EnvBase) -> Composite:
        """What the robots observe."""
        return _only(env, "observation")

    def info_spec(self, env: EnvBase) -> Composite:
        """Infos of the robots."""
        return _only(env, "info")

    def state_spec(self, env: EnvBase) -> Composite:
        """True poses and all beliefs, for mixers and centralised critics."""
        return Composite({"state": env.full_observation_spec_unbatched["state"].clone()})

    def action_spec(self, env: EnvBase) -> Composite:
        """What the robots do."""
        return env.full_action_spec_unbatched

    def action_mask_spec(self, env: EnvBase) -> None:
        """Every action can be chosen at any time."""
        return

    def log_info(self, batch: TensorDictBase) -> dict[str, float]:
        """The means of the logged numbers of the episodes that ended in a batch."""
        episodes = self._one_world.episodes(batch)
        return {f"collection/{name}": float(v.mean()) for name, v in episodes.items() if len(v)}

    def get_env_transforms(self, env: EnvBase) -> list[Transform]:
        """The scale of the rewards."""
        keys = [(group, "reward") for group in self.group_map(env)]
        return [RewardScaling(0.0, self._reward_scale, in_keys=keys)]

    def get_reward_sum_transform(self, env: EnvBase) -> RewardSum:
        """Of the worlds of training only: sums of rewards, and episodes of all phases at once."""
        return StaggeredRewardSum(reset_keys=["_reset"])

    @staticmethod
    def render_callback(experiment: Experiment, env: EnvBase, data: TensorDictBase) -> Frame:
        """A small frame of the first world."""
        for logger in experiment.logger.loggers:
            if isinstance(logger, CSVLogger):  # its own writer is gone from torchvision
                logger.log_video = partial(write_video, Path(logger.experiment.log_dir))
        return np.ascontiguousarray(env.render()[::2, ::2])

    @staticmethod
    def env_name() -> str:
        """The name under which BenchMARL looks for tasks and files results."""
        return "swarm_forage"

    @cached_property
    def _one_world(self) -> SwarmTorchEnv:
        """Knows what is logged, and how."""
        return SwarmTorchEnv(**self.config)


class StaggeredRewardSum(RewardSum):  # type: ignore[misc]
    """Sums up the rewards of episodes, the first of which end one after the other.

    Else all worlds are in one phase of their episodes at once: a policy that learns from the last
    ones forgets what it learned from the first.
    """

    _has_begun = False

    def _reset(
        self, tensordict: TensorDictBase, tensordict_reset: TensorDictBase
    ) -> TensorDictBase:
        """After the first reset, which starts all worlds."""
        if not self._has_begun:
            self.parent.base_env.array_env.episodes.stagger()
            self._has_begun = True
        return super()._reset(tensordict, tensordict_reset)


class EpisodeMetrics(Callback):  # type: ignore[misc]
    """Logs the metrics of the episodes of an evaluation, as their round trips.

    The first one, the score, is written beside the return into the JSON file of marl-eval. `last`
    holds those of the last evaluation: by name, a number for each episode.
    """

    def __init__(self) -> None:
        super().__init__()
        self.last: dict[str, Tensor] = {}

    def on_evaluation_end(self, rollouts: list[TensorDictBase]) -> None:
        """Log the means, and the score of each episode."""
        experiment = self.experiment
        env = experiment.test_env
        episodes = [env.episodes(each) for each in rollouts]
        self.last = {name: torch.cat([each[name] for each in episodes]) for name in episodes[0]}
        means = {f"eval/{name}": float(values.mean()) for name, values in self.last.items()}
        experiment.logger.log(means, step=experiment.n_iters_performed)
        writer = experiment.logger.json_writer
        if writer is not None:
            score, *_ = self.last.items()
            frames, interval = experiment.total_frames, experiment.config.evaluation_interval
            writer.write(frames, dict([score]), frames // interval)


class KeepsPolicy(Callback):  # type: ignore[misc]
    """Keeps the latest policy in the experiment's folder with its card, as `policy.pt`.

    `swarm-forage evaluate near torchscript:policy.pt` runs it under the keywords of the training.
    """

    def on_train_end(self, training_td: TensorDictBase, group: str) -> None:
        """Keep what the last update has made."""
        experiment = self.experiment
        save_policy(experiment.policy, experiment.test_env, experiment.folder_name / "policy.pt")


def write_video(folder: Path, name: str, video: Tensor, step: int) -> None:
    """Write the frames of an evaluation, of shape (1, frames, 3, height, width), to an MP4."""
    frames = video[0].permute(0, 2, 3, 1).numpy()
    _, height, width, _ = frames.shape
    made = Video(folder / "videos" / f"{name}_{step}.mp4", width, height)
    for frame in frames:
        made.add(np.ascontiguousarray(frame))
    made.close()


def _only(env: EnvBase, kind: str) -> Composite:
    """One kind of observations or infos of a group of robots."""
    spec = env.full_observation_spec_unbatched
    return Composite(
        {
            group: Composite({kind: spec[group, kind].clone()}, shape=spec[group].shape)
            for group in env.group_map
        }
    )


def _read(file: Path) -> dict[str, Any]:
    """The keywords of a file, without Hydra's."""
    keywords: dict[str, Any] = yaml.safe_load(file.read_text(encoding="utf-8"))
    keywords.pop("defaults", None)
    return keywords


class _FromFiles(Task):  # type: ignore[misc]
    """Reads its tasks from the files of this package."""

    @staticmethod
    def associated_class() -> type[SwarmForageClass]:
        """What makes the worlds."""
        return SwarmForageClass

    def get_from_yaml(self, path: str | None = None) -> SwarmForageClass:
        """The task under the keywords of its file, or of another."""
        file = FOLDER / f"{self.name.lower()}.yaml" if path is None else Path(path)
        return SwarmForageClass(self.name, _read(file))


SwarmForageTask = _FromFiles(
    "SwarmForageTask",
    {file.stem.upper(): None for file in sorted(FOLDER.glob("*.yaml"))},
    module=__name__,
)
"""A task for each file; `get_task(config=...)` takes other keywords."""

task_config_registry |= {f"swarm_forage/{task.name.lower()}": task for task in SwarmForageTask}


def settings(task: TaskClass, **changes: object) -> ExperimentConfig:
    """BenchMARL's settings of an experiment with those of `conf/experiment/swarm_forage.yaml`,
    the task's discount, and these changes."""
    config = ExperimentConfig.get_from_yaml()
    discount = task.config.get("discount", EnvConfig.model_fields["discount"].default)
    own = {**_read(CONF / "experiment" / "swarm_forage.yaml"), "gamma": discount}
    for name, value in {**own, **changes}.items():
        if name not in vars(config):
            raise UnknownNameError("setting of an experiment", name, vars(config))
        setattr(config, name, value)
    return config
