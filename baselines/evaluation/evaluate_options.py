"""Options of the command `evaluate`, checked as a whole before anything runs."""

import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path

from baselines.controller import LayeredController
from baselines.evaluation.console import of_option, say
from baselines.evaluation.dataset import folder_name, open_dataset
from baselines.evaluation.experiment_config import (
    ExperimentConfig,
    find_layered_controller,
    parse_settings,
)
from baselines.evaluation.runner import Plan
from baselines.evaluation.trajectories import Trajectories, kind_of
from swarm_forage_env.device_loop import placed
from swarm_forage_env.device_memory import usable_gpu
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.loop import Loop
from swarm_forage_env.physics import ENGINES
from swarm_forage_env.random_streams import checked_seed
from swarm_forage_env.scenarios import find_scenario
from swarm_forage_env.task import task_of
from swarm_forage_env.worlds_on_cpu import Device


@dataclass(frozen=True)
class EvaluateOptions:
    """Options of `evaluate`: controllers on a scenario, all under the same seeds."""

    scenario: str
    controllers: Sequence[str]
    episodes: int = 30
    seed: int = 0
    settings: Sequence[str] = ()  # changed parameters of the scenario: `radio.max_range=0.2`
    physics: str | None = None  # None: the engine of the scenario's task

    def plan(
        self, out: Path | str | None, trajectories: bool = False, device: Device = "cpu"
    ) -> Plan:
        """Plan the episodes: those found in the dataset `out`, and those to run.

        UnknownNameError for an unknown name, ConfigError for any other wrong option.
        """
        configurations, seeds = self.configurations(), self.seeds()
        scenario = configurations[0].scenario
        if trajectories and device != "cpu":
            raise ConfigError(
                f"--trajectories: are recorded on a CPU only; leave out --device={device}"
            )
        if trajectories and "://" in str(out):
            raise ConfigError(f"--trajectories: need a folder on this machine as --out, not {out}")
        if trajectories:
            kind_of(task_of(scenario))
        with of_option("--"):
            for each in configurations:
                check_device(device, each.physics)
                terms = each.scenario, each.controller, (0,), each.physics
                placed(Loop(*terms, is_blank=True), device)
        dataset = open_dataset(str(out or Path("runs") / folder_name(scenario.name)))
        trajectory_files = Trajectories(dataset) if trajectories else None
        if trajectory_files:
            trajectory_files.open()
        return Plan(configurations, seeds, dataset, trajectory_files)

    def configurations(self) -> list[ExperimentConfig]:
        """Return the configuration of each controller; ConfigError if two are the same."""
        scenario = find_scenario(self.scenario)
        changes = parse_settings(self.settings)
        with of_option("--set: "):
            scenario = find_scenario(scenario, changes)
        physics = self.physics or task_of(scenario).physics
        check_physics(physics)
        configurations = [
            ExperimentConfig(each, scenario, self.find(each), physics) for each in self.controllers
        ]
        for one, other in combinations(configurations, 2):
            if one.controller == other.controller:
                raise ConfigError(
                    f"controllers '{one.label}' and '{other.label}' are the same, with the same"
                    " parameters: name one of them"
                )
        for each in configurations:
            each.controller.check_usable(scenario)
            if assumed := each.controller.assumed(scenario):
                say(assumed)
        return configurations

    def find(self, name: str) -> LayeredController:
        """Return the controller of this name."""
        return find_layered_controller(name)

    def seeds(self) -> range:
        """Return the seeds of the episodes."""
        return seeds_from(self.seed, self.episodes)

    @property
    def command(self) -> str:
        """Command line that runs the same episodes again."""
        options = [f"--set={each}" for each in self.settings]
        options += [f"--episodes={self.episodes}", f"--seed={self.seed}"]
        options += [f"--physics={self.physics}"] if self.physics else []
        return shlex.join(["swarm-forage", "evaluate", self.scenario, *self.controllers, *options])


def seeds_from(first: int, episodes: int) -> range:
    """Return the seeds of this many episodes; ConfigError if one is no valid seed."""
    check_count("--episodes", episodes)
    with of_option("--"):
        return range(checked_seed(first), checked_seed(first + episodes - 1) + 1)


def check_physics(name: str) -> None:
    """Raise ConfigError unless an engine has this name."""
    with of_option("--physics: "):
        _ = ENGINES[name]


def check_device(device: Device, physics: str) -> None:
    """Raise ConfigError unless the device is usable and runs the engine."""
    if device == "cuda" and physics != "kinematic":
        raise ConfigError(
            f"device=cuda: the engine {physics} calls a library that runs on a CPU only; add"
            " --physics=kinematic"
        )
    if device == "cuda":
        usable_gpu()


def check_count(option: str, value: int) -> None:
    """Raise ConfigError unless the value of an option is at least 1."""
    if value < 1:
        raise ConfigError(f"{option}={value}: must be at least 1")
