"""Train by BenchMARL: IPPO, MAPPO, VDN, QMIX, MASAC and what else it has."""

import contextlib
import copy
import os
import tempfile
from typing import Any

import torch
from benchmarl.algorithms import algorithm_config_registry
from benchmarl.environments import TaskClass
from benchmarl.experiment import Callback, Experiment
from benchmarl.models.mlp import MlpConfig
from tensordict import TensorDict
from torchrl.envs.utils import ExplorationType, set_exploration_type

from swarm_forage_env.arrays import Array
from training.benchmarl_tasks import SwarmForageClass, settings
from training.ladder.algorithms import Algorithm
from training.ladder.play import Act, Watch
from training.ladder.rungs import Rung

SILENT = {
    "evaluation": False,
    "render": False,
    "create_json": False,
    "loggers": [],
}
"""Settings of an experiment that another one watches over."""


def is_discrete(algorithm: Algorithm) -> bool:
    """It chooses among a few actions, as it knows no others."""
    return not algorithm_config_registry[algorithm.algorithm].supports_continuous_actions()


def train(rung: Rung, algorithm: Algorithm, seed: int, watch: Watch) -> None:
    """Train from scratch, for as many robot-steps as the watch says."""
    torch.set_num_threads(1)
    task = SwarmForageClass(rung.name, {**rung.keywords, **algorithm.keywords})
    with tempfile.TemporaryDirectory() as folder:
        experiment = _experiment(task, algorithm, seed, folder, watch)
        with open(os.devnull, "w") as nowhere, contextlib.redirect_stderr(nowhere):
            experiment.run()


def _experiment(
    task: TaskClass, algorithm: Algorithm, seed: int, folder: str, watch: Watch
) -> Experiment:
    """BenchMARL's experiment, watched."""
    config = algorithm_config_registry[algorithm.algorithm].get_from_yaml()
    for name, value in algorithm.settings.items():
        setattr(config, name, value)
    env = task.get_env_fun(1, not is_discrete(algorithm), None, "cpu")()
    ticks = len(env.array_env.learners) * (env.array_env.config.decision_period or 1)
    frames = -(-watch.robot_steps // ticks)
    own = {**SILENT, "save_folder": folder, "max_n_frames": frames, **algorithm.experiment}
    return Experiment(
        task=task,
        algorithm_config=config,
        model_config=MlpConfig.get_from_yaml(),
        critic_model_config=MlpConfig.get_from_yaml(),
        seed=seed,
        config=settings(task, **own),
        callbacks=[_Watcher(watch, ticks, env.group)],
    )


class _Watcher(Callback):  # type: ignore[misc]
    """Evaluates after updates, when it is time."""

    def __init__(self, watch: Watch, ticks: int, group: str) -> None:
        super().__init__()
        self._watch, self._ticks, self._group = watch, ticks, group

    def on_train_end(self, training_td: Any, group: str) -> None:  # noqa: ANN401 as BenchMARL's
        """Evaluate what the last update has made."""
        robot_steps = self.experiment.total_frames * self._ticks
        if self._watch.due(robot_steps):
            policy = self.experiment.policy
            self._watch.evaluate(
                robot_steps,
                _acting(policy, self._group),
                lambda: _acting(copy.deepcopy(policy), self._group),
            )


def _acting(policy: Any, group: str) -> Act:  # noqa: ANN401 a TensorDictModule
    """The policy without its chance."""

    def act(observations: Array) -> Array:
        worlds, robots = observations.shape[:2]
        seen = TensorDict({"observation": torch.from_numpy(observations)}, [worlds, robots])
        told = TensorDict({group: seen}, [worlds])
        with torch.no_grad(), set_exploration_type(ExplorationType.DETERMINISTIC):
            actions: Array = policy(told)[group, "action"].numpy()
        return actions

    return act
