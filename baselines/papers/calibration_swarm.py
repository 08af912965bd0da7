"""What a set of values gives: the episodes it is measured by, and each parameter's part in it."""

import hashlib
import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass, field, replace

from baselines.evaluation.dataset import Dataset
from baselines.evaluation.experiment_config import ExperimentConfig
from baselines.evaluation.runner import evaluate
from baselines.evaluation.statistics import Estimate
from baselines.papers.calibration_ranges import (
    ARENAS,
    RANGES,
    Values,
    defaults,
    recipe_with,
    scenario_with,
)
from baselines.papers.calibration_targets import (
    CONTROLLERS,
    TARGETS,
    Cells,
    Target,
    estimate,
    measure,
    of_arenas,
)

FIT_SEED, REPORT_SEED = 5000, 6000
"""First seeds of the worlds that a set is fitted to, and of those that it is reported on."""

WORLDS = {"es1": 6, "es2": 1, "es3": 1}
"""Worlds of each arena that a trial is measured in: about as many robots everywhere."""

Objective = Callable[[Values, str], dict[Target, float]]
"""Measures a set of values in an arena."""


@dataclass(frozen=True)
class CalibrationRunner:
    """How a set of values is measured: in which worlds, and on which engine."""

    dataset: Dataset
    physics: str = "kinematic"
    workers: int = 1
    seed: int = FIT_SEED
    worlds: Mapping[str, int] = field(default_factory=lambda: WORLDS)
    settings: Mapping[str, str] = field(default_factory=dict)
    """Numbers of every scenario to change besides: `task.duration`."""

    def __call__(self, values: Values, arena: str) -> dict[Target, float]:
        """Every target of an arena as measured."""
        cells = self.cells(values, arena)
        return {target: measure(target, cells) for target in of_arenas([arena])}

    def cells(self, values: Values, arena: str) -> Cells:
        """The episodes of an arena, run or found."""
        configurations = [self.configuration(values, arena, each) for each in CONTROLLERS]
        seeds = range(self.seed, self.seed + self.worlds[arena])
        episodes = evaluate(configurations, seeds, self.dataset, self.workers)
        return {
            (arena, name): [each for each in episodes if each.controller == name]
            for name in CONTROLLERS
        }

    def configuration(self, values: Values, arena: str, controller: str) -> ExperimentConfig:
        """A scenario and a controller with these values."""
        scenario = scenario_with(values, arena, self.settings)
        return ExperimentConfig(controller, scenario, recipe_with(values, controller), self.physics)

    @property
    def identity(self) -> str:
        """A hash of all that a score depends on but the values: scores of one are comparable."""
        code = self.configuration(defaults(), ARENAS[0], CONTROLLERS[0]).code
        tables = [asdict(each) for each in TARGETS], [asdict(each) for each in RANGES]
        rest = [code, self.physics, self.seed, dict(self.worlds), dict(self.settings)]
        return hashlib.sha256(json.dumps([tables, rest]).encode()).hexdigest()[:16]

    def elsewhere(self, worlds: int) -> "CalibrationRunner":
        """The same in so many worlds that no set has been fitted to."""
        return replace(self, seed=REPORT_SEED, worlds=dict.fromkeys(ARENAS, worlds))


@dataclass(frozen=True)
class Varied:
    """A set in which one parameter has another value."""

    parameter: str
    value: float
    measured: Mapping[Target, float]


def all_arenas(values: Values, objective: Objective) -> dict[Target, float]:
    """Every target as measured."""
    return {target: ours for arena in ARENAS for target, ours in objective(values, arena).items()}


def estimates(values: Values, swarm: CalibrationRunner) -> dict[Target, Estimate | None]:
    """Every target with its interval."""
    cells = {cell: ran for arena in ARENAS for cell, ran in swarm.cells(values, arena).items()}
    return {target: estimate(target, cells) for target in TARGETS}


def sensitivity(values: Values, objective: Objective) -> Iterator[Varied]:
    """Each parameter varied alone, down and up, as far as its range goes."""
    for each in RANGES:
        for value in each.beside(values[each.name]):
            if value != values[each.name]:
                measured = all_arenas(dict(values) | {each.name: value}, objective)
                yield Varied(each.name, value, measured)
