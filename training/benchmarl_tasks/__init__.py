"""Tasks for BenchMARL, each of them a file of keywords of `parallel_env`.

    python -m training.benchmarl_tasks task=swarm_forage/near algorithm=mappo

Each file in `conf/task/swarm_forage` is a task of the enum; a new file adds a task.
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
"""Longest episode that is drawn to a video [steps]: BenchMARL holds all of its frames in memory."""


class SwarmForageClass(TaskClass):  # type: ignore[misc]
    """Description of a task for BenchMARL: how to make its environment, and what it supports.

    `config` holds keywords of `parallel_env` and `reward_scale`, a factor of the rewards: values of
    0.01, as those of round trips, drown in the noise of a value network's updates. The card of a
    rung (`training.ladder`) is ignored. `discrete` applies to algorithms of discrete actions only,
    which use the default choices without it.
    """

    def __init__(self, name: str, config: dict[str, Any]) -> None:
        own = {key: value for key, value in config.items() if key != "card"}
        self._reward_scale = float(own.pop("reward_scale", 1.0))
        super().__init__(name, own)

    def get_env_fun(
        self, num_envs: int, continuous_actions: bool, seed: int | None, device: torch.device | str
    ) -> Callable[[], EnvBase]:
        """Return a function that makes one block of `num_envs` worlds.

        BenchMARL gives one seed to the worlds of training and of evaluation. Here each block draws
        its own seed from torch, so that no policy is evaluated on episodes of its training.
        """
        discrete = False if continuous_actions else self.config.get("discrete") or True
        options = {**self.config, "discrete": discrete, "n_worlds": num_envs, "device": device}
        return lambda: SwarmTorchEnv(**options, seed=int(torch.randint(2**31, ())))

    def supports_continuous_actions(self) -> bool:
        """Return True: steering and weights can be continuous."""
        return True

    def supports_discrete_actions(self) -> bool:
        """Return True: steering and weights can be choices among a few values."""
        return True

    def has_render(self, env: EnvBase) -> bool:
        """Return whether worlds can be drawn, episodes are short, and `render` is installed."""
        has_extra = all(find_spec(name) for name in EXTRAS["render"])
        return has_extra and env.has_render and env.max_cycles <= MAX_FRAMES

    def max_steps(self, env: EnvBase) -> int:
        """Return the number of decisions in an episode."""
        return int(env.max_cycles)

    def group_map(self, env: EnvBase) -> dict[str, list[str]]:
        """Return one group of all robots that learn."""
        return dict(env.group_map)

    def observation_spec(self, env: EnvBase) -> Composite:
        """Return the spec of the robots' observations."""
        return _only(env, "observation")

    def info_spec(self, env: EnvBase) -> Composite:
        """Return the spec of the robots' infos."""
        return _only(env, "info")

    def state_spec(self, env: EnvBase) -> Composite:
        """Return the spec of true poses and all beliefs, for mixers and centralised critics."""
        return Composite({"state": env.full_observation_spec_unbatched["state"].clone()})

    def action_spec(self, env: EnvBase) -> Composite:
        """Return the spec of the robots' actions."""
        return env.full_action_spec_unbatched

    def action_mask_spec(self, env: EnvBase) -> None:
        """Return None: every action can be chosen at any time."""
        return

    def log_info(self, batch: TensorDictBase) -> dict[str, float]:
        """Return the means of the logged metrics of the episodes that ended in a batch."""
        episodes = self._one_world.episodes(batch)
        return {f"collection/{name}": float(v.mean()) for name, v in episodes.items() if len(v)}

    def get_env_transforms(self, env: EnvBase) -> list[Transform]:
        """Return the transform that scales the rewards."""
        keys = [(group, "reward") for group in self.group_map(env)]
        return [RewardScaling(0.0, self._reward_scale, in_keys=keys)]

    def get_reward_sum_transform(self, env: EnvBase) -> RewardSum:
        """Return the transform that sums rewards and staggers first episodes, for training only."""
        return StaggeredRewardSum(reset_keys=["_reset"])

    @staticmethod
    def render_callback(experiment: Experiment, env: EnvBase, data: TensorDictBase) -> Frame:
        """Return a frame of the first world, at half the resolution."""
        for logger in experiment.logger.loggers:
            if isinstance(logger, CSVLogger):  # torchvision no longer has its writer
                logger.log_video = partial(write_video, Path(logger.experiment.log_dir))
        return np.ascontiguousarray(env.render()[::2, ::2])

    @staticmethod
    def env_name() -> str:
        """Return the name under which BenchMARL finds tasks and stores results."""
        return "swarm_forage"

    @cached_property
    def _one_world(self) -> SwarmTorchEnv:
        """One world, which provides the names of the logged metrics and how to combine them."""
        return SwarmTorchEnv(**self.config)


class StaggeredRewardSum(RewardSum):  # type: ignore[misc]
    """Sum of the rewards of each episode; the first episodes of the worlds end at different times.

    Otherwise all worlds are in the same phase of their episodes: a policy that learns from late
    phases forgets what it learned from early ones.
    """

    _has_begun = False

    def _reset(
        self, tensordict: TensorDictBase, tensordict_reset: TensorDictBase
    ) -> TensorDictBase:
        """Stagger the episodes at the first reset, which starts all worlds."""
        if not self._has_begun:
            self.parent.base_env.array_env.episodes.stagger()
            self._has_begun = True
        return super()._reset(tensordict, tensordict_reset)


class EpisodeMetrics(Callback):  # type: ignore[misc]
    """Callback that logs metrics of the episodes of an evaluation, such as their round trips.

    The first metric, the score, is also written to the JSON file of marl-eval, with the return.
    `last` holds the metrics of the last evaluation: by name, one value per episode.
    """

    def __init__(self) -> None:
        super().__init__()
        self.last: dict[str, Tensor] = {}

    def on_evaluation_end(self, rollouts: list[TensorDictBase]) -> None:
        """Log the means of the metrics, and the score of each episode."""
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
    """Callback that saves the latest policy and its card in the experiment's folder: `policy.pt`.

    `swarm-forage evaluate near torchscript:policy.pt` runs it under the keywords of the training.
    """

    def on_train_end(self, training_td: TensorDictBase, group: str) -> None:
        """Save the policy after an update."""
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
    """Return the spec of one kind of entry, observations or infos, for each group of robots."""
    spec = env.full_observation_spec_unbatched
    return Composite(
        {
            group: Composite({kind: spec[group, kind].clone()}, shape=spec[group].shape)
            for group in env.group_map
        }
    )


def _read(file: Path) -> dict[str, Any]:
    """Read the keywords of a file, without Hydra's."""
    keywords: dict[str, Any] = yaml.safe_load(file.read_text(encoding="utf-8"))
    keywords.pop("defaults", None)
    return keywords


class _FromFiles(Task):  # type: ignore[misc]
    """Enum of tasks that are read from the files of this package."""

    @staticmethod
    def associated_class() -> type[SwarmForageClass]:
        """Return the class that makes the worlds."""
        return SwarmForageClass

    def get_from_yaml(self, path: str | None = None) -> SwarmForageClass:
        """Return the task under the keywords of its file, or of the file at `path`."""
        file = FOLDER / f"{self.name.lower()}.yaml" if path is None else Path(path)
        return SwarmForageClass(self.name, _read(file))


SwarmForageTask = _FromFiles(
    "SwarmForageTask",
    {file.stem.upper(): None for file in sorted(FOLDER.glob("*.yaml"))},
    module=__name__,
)
"""Enum with a task for each file; `get_task(config=...)` takes other keywords."""

task_config_registry |= {f"swarm_forage/{task.name.lower()}": task for task in SwarmForageTask}


def settings(task: TaskClass, **changes: object) -> ExperimentConfig:
    """Return BenchMARL's settings of an experiment, changed by `conf/experiment/swarm_forage.yaml`,
    by the discount of the task, and by `changes`. UnknownNameError for an unknown setting."""
    config = ExperimentConfig.get_from_yaml()
    discount = task.config.get("discount", EnvConfig.model_fields["discount"].default)
    own = {**_read(CONF / "experiment" / "swarm_forage.yaml"), "gamma": discount}
    for name, value in {**own, **changes}.items():
        if name not in vars(config):
            raise UnknownNameError("setting of an experiment", name, vars(config))
        setattr(config, name, value)
    return config
