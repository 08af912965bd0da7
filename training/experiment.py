"""Options of a training run, validated as a whole before anything runs."""

import hashlib
import shlex
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from importlib.metadata import version
from pathlib import Path

import numpy as np

from baselines.controller import LayeredController
from baselines.evaluation.console import of_option
from baselines.evaluation.evaluate_options import check_count, check_device, check_physics
from baselines.motion.subsumption import SubsumptionParameters
from swarm_forage_env.controllers import find_controller, parse_controller
from swarm_forage_env.errors import ConfigError, UnknownNameError
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.interface import files_read_by
from swarm_forage_env.parameters import leaves
from swarm_forage_env.random_streams import checked_seed
from swarm_forage_env.scenarios import find_scenario
from swarm_forage_env.task import task_of
from swarm_forage_env.worlds_on_cpu import checked_device
from training.learned_weighting import LearnedLayer
from training.linear_motion_policy import LINEAR_MOTION
from training.policy_file import LayerName, Policy, load_policy, observation_features

LAYERS: dict[str, tuple[LayerName, ...]] = {
    "weighting": ("weighting",),
    "motion": ("motion",),
    "both": ("weighting", "motion"),
    "everything": (),
}
"""Layers of the controller that are replaced, for each choice of what is trained."""

TEST_SEEDS = range(1_000, 1_030)
"""Test seeds, for the final score of a policy: never used in training or selection."""

HELD_BACK_SEEDS = range(2_000, 3_000)
"""Validation seeds, by which the best policy is chosen during training."""

FIRST_TRAINING_SEED = 10_000
WORLDS_PER_EXPERIMENT = 10**7
LAST_SEED = 10**9
"""Largest seed of an experiment. Each experiment trains on its own range of world seeds."""

PACKAGES = ("swarm-forage", "numpy", "numba", "pymunk", "safetensors")


@dataclass(frozen=True)
class Experiment:
    """Options of one training run: everything that its result depends on."""

    layer: str
    scenarios: tuple[str, ...]
    """Names or files of scenarios, each with its own changes: `es1:radio.frames=50`."""
    algorithm: str
    out: Path
    seed: int = 0
    budget: int = 100  # generations (cma), rounds (imitation) or robot steps (ppo)
    every: int = 5  # generations, rounds or robot steps between two evaluations
    worlds: int = 8
    """Parallel worlds: for each candidate in each scenario (cma), or of the scenario with the
    fewest robots (imitation and ppo); scenarios with more robots get fewer worlds."""
    held_back: int = 10  # number of held-back seeds of an evaluation, in each scenario
    population: int | None = None  # candidates of a generation (cma); None: the default of CMA-ES
    settings: Mapping[str, str] = field(default_factory=dict)
    """Changes to the parameters of all scenarios, by dotted name."""
    controller: str = "ssgiff"  # controller whose other layers are used
    physics: str = "rigid"
    workers: int = 1
    device: str = "cpu"  # where worlds run, and for ppo the learner: "cpu" or "cuda"

    def check(self) -> None:
        """Raise ConfigError or UnknownNameError for the first invalid option."""
        if self.algorithm == "cma" and len(self.layers) != 1:
            raise ConfigError(
                f"--algorithm=cma: trains one layer at a time, not {self.layer}; use ppo"
            )
        if self.algorithm == "imitation" and self.layer != "weighting":
            raise ConfigError(
                f"--algorithm=imitation: trains the weighting only, not {self.layer}; the right"
                " action is known for an exchange, but not for a motion; use ppo"
            )
        self._check_numbers()
        self._check_worlds()
        self._check_device()
        if self.algorithm != "cma" or self.layer != "motion":
            return
        policy = self.policy_of("motion")
        if policy is not None:
            LINEAR_MOTION.numbers_of(policy)
        elif self.base_controller.motion != SubsumptionParameters():
            raise ConfigError(
                f"--controller={self.controller}: cma trains a correction of subsumption with"
                " its default parameters; change no parameter of the motion"
            )

    def _check_numbers(self) -> None:
        for option in ("budget", "every", "worlds", "workers"):
            check_count(f"--{option}", vars(self)[option])
        if not 1 <= self.held_back <= len(HELD_BACK_SEEDS):
            raise ConfigError(
                f"--held-back={self.held_back}: must be from 1 to {len(HELD_BACK_SEEDS)}"
            )
        if self.population is not None and self.algorithm != "cma":
            raise ConfigError(f"--population={self.population}: is for --algorithm cma")
        if self.population is not None and self.population < 4:
            raise ConfigError(f"--population={self.population}: must be at least 4")
        with of_option("--"):
            checked_seed(self.seed)
        if self.seed > LAST_SEED:
            raise ConfigError(f"--seed={self.seed}: must be at most {LAST_SEED}")

    def _check_device(self) -> None:
        with of_option("--"):
            device = checked_device(self.device)
            if device == "cpu":
                return
            if self.algorithm == "imitation":
                raise ConfigError("device=cuda: is for --algorithm cma and ppo, not imitation")
            check_device(device, self.physics)
            if self.algorithm == "ppo":
                from training.tensor_vec_env import torch_device

                torch_device(self.device)

    def _check_worlds(self) -> None:
        repeated = [each for each in self.scenarios if self.scenarios.count(each) > 1]
        if repeated:
            raise ConfigError(f"scenario '{repeated[0]}' is named twice")
        check_physics(self.physics)
        for scenario in self.scenarios_by_name.values():
            self.base_controller.check_supports(scenario)
        (first, scenario), *others = self.scenarios_by_name.items()
        features = observation_features(self.layer, scenario)
        for name, each in others:
            if observation_features(self.layer, each) != features:
                raise ConfigError(
                    f"scenarios '{first}' and '{name}': a policy observes other features in"
                    " each, so that none fits both; radio.slots determines their number"
                )

    @cached_property
    def scenarios_by_name(self) -> dict[str, Scenario]:
        """Scenarios with all changes applied, by their names with changes."""
        scenarios: dict[str, Scenario] = {}
        for text in self.scenarios:
            name, changes = parse_controller(text, "scenario", "es1:radio.frames=5")
            scenario: Scenario = find_scenario(name, {**self.settings, **changes})
            if task_of(scenario).name != "foraging":
                raise ConfigError(
                    f"scenario '{scenario.name}': must be one in which robots forage, such as es1"
                )
            scenarios[text] = scenario
        return scenarios

    @cached_property
    def base_controller(self) -> LayeredController:
        """Controller whose layers are replaced; ConfigError unless it consists of layers alone."""
        controller = find_controller(self.controller)
        if not isinstance(controller, LayeredController) or "policy" in controller.layers:
            raise ConfigError(
                f"--controller={self.controller}: must be made of three layers, such as ssgikf"
                " or learned-weighting; a policy of ppo or of another trainer runs beside such"
                " layers only, and `swarm-forage train both` trains one policy of both"
            )
        return controller

    def policy_of(self, layer: LayerName) -> Policy | None:
        """Return the policy of a layer of the controller; None if the layer is hand-written."""
        part = self.base_controller.layers[layer]
        return load_policy(part.policy) if isinstance(part, LearnedLayer) else None

    @property
    def layers(self) -> tuple[LayerName, ...]:
        """Layers that are trained."""
        if self.layer not in LAYERS:
            raise UnknownNameError("layer to learn", self.layer, LAYERS)
        return LAYERS[self.layer]

    @property
    def held_back_seeds(self) -> range:
        """Held-back (validation) seeds of this experiment."""
        return HELD_BACK_SEEDS[: self.held_back]

    def training_seeds(self, first: int, count: int) -> range:
        """Return the seeds of `count` training worlds, after the first `first` ones."""
        if first + count > WORLDS_PER_EXPERIMENT:
            raise ConfigError(f"more than {WORLDS_PER_EXPERIMENT} training worlds")
        start = FIRST_TRAINING_SEED + self.seed * WORLDS_PER_EXPERIMENT + first
        return range(start, start + count)

    @property
    def identity(self) -> dict[str, str]:
        """Everything that the result depends on, except how long it runs; stored in checkpoints."""
        controller = self.base_controller
        names = ["layer", "algorithm", "scenarios", "controller", "seed", "every", "worlds"]
        names += ["held_back", "population", "physics"]
        if self.algorithm == "imitation":  # the learning rate falls to zero over the budget
            names.append("budget")
        if self.device != "cpu":  # a GPU rounds differently
            names.append("device")
        terms = vars(self) | {"scenarios": " ".join(self.scenarios), "controller": controller.name}
        identity = {name: str(terms[name]) for name in names}
        for name, scenario in self.scenarios_by_name.items():
            identity |= {f"{name} {k}": str(v) for k, v in leaves(scenario.model_dump()).items()}
        identity |= {f"{controller.name} {k}": str(v) for k, v in controller.parameters.items()}
        for layer, part in controller.layers.items():
            for file in files_read_by(part):
                digest = hashlib.sha256(file.read_bytes()).hexdigest()
                identity[f"{controller.name} {layer}, sha256"] = digest
        return identity

    @property
    def command(self) -> str:
        """Command line that runs the same experiment again."""
        names = ["algorithm", "seed", "budget", "every", "worlds", "held_back", "controller"]
        names += ["physics", "workers", "out"]
        names += ["population"] if self.population is not None else []
        names += ["device"] if self.device != "cpu" else []
        words = ["swarm-forage", "train", self.layer, *self.scenarios]
        words += [f"--{name.replace('_', '-')}={vars(self)[name]}" for name in names]
        words += [f"--set={name}={value}" for name, value in self.settings.items()]
        return shlex.join(words)


def worlds_per_scenario(experiment: Experiment) -> dict[str, int]:
    """Return the number of worlds of each scenario, so that all have about as many robots."""
    robots = {name: each.task.n_robots for name, each in experiment.scenarios_by_name.items()}
    fewest = min(robots.values())
    return {name: max(1, experiment.worlds * fewest // n) for name, n in robots.items()}


def step_seed(seed: int, step: int) -> int:
    """Return the random seed of one training step (a generation or an interval)."""
    return int(np.random.SeedSequence([seed, step]).generate_state(1)[0])


def versions(*more: str) -> dict[str, str]:
    """Return the versions of the packages that a result depends on."""
    return {package: version(package) for package in (*PACKAGES, *more)}
