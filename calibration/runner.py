"""Measure a set of parameter values: run its episodes, and compare them with the targets."""

import hashlib
import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass, field, replace

from baselines.evaluation.backends import Backend
from baselines.evaluation.dataset import Dataset
from baselines.evaluation.experiment_config import ExperimentConfig
from baselines.evaluation.runner import evaluate
from baselines.evaluation.statistics import Estimate
from calibration.ranges import (
    ARENAS,
    RANGES,
    Values,
    controller_with,
    defaults,
    scenario_with,
)
from calibration.targets import (
    CONTROLLERS,
    TARGETS,
    ArenaEpisodes,
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
    """Measures a set of values in given worlds, on one engine."""

    dataset: Dataset
    physics: str = "kinematic"
    backend: Backend | None = None
    """None: this process."""
    seed: int = FIT_SEED
    worlds: Mapping[str, int] = field(default_factory=lambda: WORLDS)
    settings: Mapping[str, str] = field(default_factory=dict)
    """Numbers of every scenario to change besides: `task.duration`."""

    def __call__(self, values: Values, arena: str) -> dict[Target, float]:
        """Measure every target of an arena."""
        episodes = self.episodes(values, arena)
        return {target: measure(target, episodes) for target in of_arenas([arena])}

    def episodes(self, values: Values, arena: str) -> ArenaEpisodes:
        """The episodes of an arena by controller, run or found."""
        configurations = [self.configuration(values, arena, each) for each in CONTROLLERS]
        seeds = range(self.seed, self.seed + self.worlds[arena])
        episodes = evaluate(configurations, seeds, self.dataset, self.backend)
        return {
            (arena, name): [each for each in episodes if each.controller == name]
            for name in CONTROLLERS
        }

    def configuration(self, values: Values, arena: str, controller: str) -> ExperimentConfig:
        """The configuration of a scenario and a controller with these values."""
        scenario = scenario_with(values, arena, self.settings)
        layered = controller_with(values, controller)
        return ExperimentConfig(controller, scenario, layered, self.physics)

    @property
    def identity(self) -> str:
        """Hash of all that a score depends on but the values, so that scores compare."""
        code = self.configuration(defaults(), ARENAS[0], CONTROLLERS[0]).code
        tables = [asdict(each) for each in TARGETS], [asdict(each) for each in RANGES]
        rest = [code, self.physics, self.seed, dict(self.worlds), dict(self.settings)]
        return hashlib.sha256(json.dumps([tables, rest]).encode()).hexdigest()[:16]

    def on_report_worlds(self, worlds: int) -> "CalibrationRunner":
        """The same runner on worlds that no set has been fitted to."""
        return replace(self, seed=REPORT_SEED, worlds=dict.fromkeys(ARENAS, worlds))


@dataclass(frozen=True)
class SensitivityResult:
    """The measured targets of a set in which one parameter has another value."""

    parameter: str
    value: float
    measured: Mapping[Target, float]


def all_arenas(values: Values, objective: Objective) -> dict[Target, float]:
    """Measure every target of every arena."""
    return {target: ours for arena in ARENAS for target, ours in objective(values, arena).items()}


def estimates(values: Values, runner: CalibrationRunner) -> dict[Target, Estimate | None]:
    """Measure every target with its interval."""
    episodes = {key: ran for arena in ARENAS for key, ran in runner.episodes(values, arena).items()}
    return {target: estimate(target, episodes) for target in TARGETS}


def sensitivity(values: Values, objective: Objective) -> Iterator[SensitivityResult]:
    """Vary each parameter alone, down and up, as far as its range goes."""
    for each in RANGES:
        for value in each.step_around(values[each.name]):
            if value != values[each.name]:
                measured = all_arenas(dict(values) | {each.name: value}, objective)
                yield SensitivityResult(each.name, value, measured)
