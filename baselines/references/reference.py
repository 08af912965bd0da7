"""A recipe of layers of which some are shown the ground truth."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from baselines.controller import Controller, Recipe
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.ground_truth import GroundTruth
from swarm_forage_env.interface import Estimator, Weighting
from swarm_forage_env.scenario import Scenario
from swarm_forage_env.waypoints_scenario import AnyScenario


@dataclass(frozen=True)
class Reference(Recipe):
    """A named controller for comparison only; a layer with `start_knowing` is shown the truth."""

    def build(self, scenario: AnyScenario, seeds: Sequence[int]) -> Any:  # noqa: ANN401 as Recipe
        """ConfigError: a reference is built by the control loop, which knows the truth."""
        raise ConfigError(f"controller '{self.name}' needs the ground truth: use build_knowing")

    def build_knowing(
        self, scenario: Scenario, seeds: Sequence[int], truth: GroundTruth
    ) -> Controller:
        """The running controller for a block of worlds of which this is true."""
        estimator = self._estimator(scenario, len(seeds), truth)
        motion = self.motion.start(scenario, seeds)
        return Controller(estimator, self._weighting(estimator, truth), motion, scenario)

    def _estimator(self, scenario: Scenario, n_worlds: int, truth: GroundTruth) -> Estimator:
        start: Any = getattr(self.estimator, "start_knowing", None)
        estimator: Estimator = (
            start(scenario, n_worlds, truth) if start else self.estimator.start(scenario, n_worlds)
        )
        return estimator

    def _weighting(self, estimator: Estimator, truth: GroundTruth) -> Weighting:
        start: Any = getattr(self.weighting, "start_knowing", None)
        weighting: Weighting = start(estimator, truth) if start else self.weighting
        return weighting
