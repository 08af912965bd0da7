"""Training with BenchMARL: IPPO, MAPPO, VDN, QMIX, MASAC and its other algorithms."""

import contextlib
import copy
import math
import os
import tempfile

import torch
from benchmarl.algorithms import algorithm_config_registry
from benchmarl.environments import TaskClass
from benchmarl.experiment import Callback, Experiment
from benchmarl.models.mlp import MlpConfig
from tensordict import TensorDict, TensorDictBase
from tensordict.nn import TensorDictModuleBase
from torchrl.envs.utils import ExplorationType, set_exploration_type

from swarm_forage_env.arrays import Array, Bool
from training.benchmarl_tasks import SwarmForageClass, settings
from training.ladder.play import Act, Watch, robot_steps_of_a_decision
from training.ladder.rungs import Algorithm, Rung

SILENT = {"evaluation": False, "render": False, "create_json": False, "loggers": []}
"""Settings of an experiment without evaluation and logs, which the watch provides."""


class _Trained(Exception):  # noqa: N818 no error
    """Raised when the robot-steps of a training are used up."""


def train(rung: Rung, algorithm: Algorithm, seed: int, watch: Watch) -> None:
    """Train from scratch, for the number of robot-steps of the watch."""
    torch.set_num_threads(1)
    if not algorithm_config_registry[algorithm.algorithm].supports_continuous_actions():
        watch.keywords = {**watch.keywords, "discrete": watch.keywords.get("discrete") or True}
    task = SwarmForageClass(rung.name, {**rung.keywords, **algorithm.keywords})
    with tempfile.TemporaryDirectory() as folder, open(os.devnull, "w") as nowhere:
        experiment = _experiment(task, algorithm, seed, folder, watch)
        with (
            contextlib.redirect_stdout(nowhere),
            contextlib.redirect_stderr(nowhere),
            contextlib.suppress(_Trained),
        ):
            experiment.run()


def _experiment(
    task: TaskClass, algorithm: Algorithm, seed: int, folder: str, watch: Watch
) -> Experiment:
    """Return an experiment of BenchMARL, with a callback that evaluates and ends it."""
    config = algorithm_config_registry[algorithm.algorithm].get_from_yaml()
    for name, value in algorithm.settings.items():
        setattr(config, name, value)
    frames = math.ceil(watch.robot_steps / robot_steps_of_a_decision(task.config))
    own = {
        **SILENT,
        "save_folder": folder,
        "max_n_frames": watch.robot_steps,
        "exploration_anneal_frames": frames // 3,
        **algorithm.experiment,
    }
    return Experiment(
        task=task,
        algorithm_config=config,
        model_config=MlpConfig.get_from_yaml(),
        critic_model_config=MlpConfig.get_from_yaml(),
        seed=seed,
        config=settings(task, **own),
        callbacks=[_Watcher(watch)],
    )


class _Watcher(Callback):  # type: ignore[misc]
    """Callback that evaluates the policy after an update, if an evaluation is due."""

    def __init__(self, watch: Watch) -> None:
        super().__init__()
        self._watch = watch

    def on_train_end(self, training_td: TensorDictBase, group: str) -> None:
        """Evaluate the policy if that is due; raise _Trained when the robot-steps are used up."""
        experiment = self.experiment
        robot_steps = experiment.collector.env.base_env.array_env.robot_steps
        if self._watch.due(robot_steps):
            policy = experiment.policy
            self._watch.evaluate(
                robot_steps, _acting(policy, group), lambda: _acting(copy.deepcopy(policy), group)
            )
        if robot_steps >= self._watch.robot_steps:
            raise _Trained


def _acting(policy: TensorDictModuleBase, group: str) -> Act:
    def act(observations: Array, begins: Bool[Array, " worlds"], stochastic: bool) -> Array:
        how = ExplorationType.RANDOM if stochastic else ExplorationType.DETERMINISTIC
        worlds, robots = observations.shape[:2]
        seen = TensorDict({"observation": torch.from_numpy(observations)}, [worlds, robots])
        observed = TensorDict({group: seen}, [worlds])
        with torch.no_grad(), set_exploration_type(how):
            actions: Array = policy(observed)[group, "action"].numpy()
        return actions

    return act
