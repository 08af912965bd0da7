"""Named controllers: estimator + weighting + motion, each with its parameters."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from baselines.composition import Layers, Row, functions_of, no_motion
from baselines.estimators import ESTIMATORS
from baselines.motion import MOTIONS
from baselines.running import RunningLayers
from baselines.weighting import WEIGHTING_RULES
from baselines.weighting.base import no_gain
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.interface import KernelNumbers, MotionLayer, WeightingLayer
from swarm_forage_env.parameters import (
    BaseScenario,
    Parameters,
    leaves,
    override,
    validated,
    with_full_names,
)
from swarm_forage_env.task import World, task_of

REGISTRIES = {"estimator": ESTIMATORS, "weighting": WEIGHTING_RULES, "motion": MOTIONS}
"""Registry of each layer."""


@dataclass(frozen=True)
class LayeredController:
    """Controller of three layers, with a name and parameters.

    A layer is compiled if its parameters have a method `layer` that does not return None. Otherwise
    it is a rule in NumPy: a weighting is a callable, a motion is returned by its method `start`.

    >>> from swarm_forage_env.controllers import find_controller
    >>> find_controller("ssgiff:beta=0.001").parameters["weighting.beta"]
    0.001
    """

    name: str
    estimator: Any
    weighting: Any
    motion: Any

    @property
    def layers(self) -> dict[str, Parameters]:
        """Parameters of each layer."""
        return {"estimator": self.estimator, "weighting": self.weighting, "motion": self.motion}

    @property
    def parameters(self) -> dict[str, object]:
        """All parameters by dotted name."""
        return leaves({layer: part.model_dump() for layer, part in self.layers.items()})

    @property
    def layer_names(self) -> dict[str, str]:
        """Name of each layer in its registry, or the name of its class if it is not registered."""
        return {
            layer: REGISTRIES[layer].name_of(type(part)) or type(part).__name__
            for layer, part in self.layers.items()
        }

    @property
    def talks(self) -> bool:
        """Whether its robots send estimates that a weighting can use."""
        return bool(getattr(self.estimator, "speaks", True))

    def with_parameters(self, values: Mapping[str, object]) -> "LayeredController":
        """Return a copy with changed parameters, named as in `beta` or `weighting.beta`.

        The name of a layer selects another registered part, as in `estimator=dead_reckoning`, which
        keeps the parameters common to both. UnknownNameError for an unknown name, ConfigError for
        an invalid value or a missing file.
        """
        chosen = {layer: str(name) for layer, name in values.items() if layer in REGISTRIES}
        changed = self._with_layers(chosen)
        changes: dict[str, dict[str, object]] = {}
        others = {name: value for name, value in values.items() if name not in chosen}
        full = with_full_names(others, changed.parameters, f"parameter of {self.name}")
        for path, value in full.items():
            layer, _, field = path.partition(".")
            changes.setdefault(layer, {})[field] = value
        parts: dict[str, Any] = {
            layer: override(changed.layers[layer], to) for layer, to in changes.items()
        }
        for part in parts.values():
            if hasattr(part, "check_usable"):  # it also needs a file, for instance
                part.check_usable()
        return replace(changed, **parts)

    def _with_layers(self, names: Mapping[str, str]) -> "LayeredController":
        parts: dict[str, Any] = {}
        for layer, name in names.items():
            part, old = REGISTRIES[layer][name], self.layers[layer].model_dump()
            common = {field: value for field, value in old.items() if field in part.model_fields}
            parts[layer] = validated(part, common)
        return replace(self, **parts)

    def layers_in(self, scenario: BaseScenario) -> Layers:
        """Return the three layers for a scenario; ConfigError if a part does not support it."""
        estimator = self.estimator.layer(scenario)
        estimator.check_falsifiable(self.name, scenario)
        rules: dict[str, object] = {}
        if hasattr(self.weighting, "layer"):
            weighting = self.weighting.layer(scenario) or estimator.own_weighting
        else:
            weighting = WeightingLayer(no_gain, heard_p_share=self.weighting.heard_p_share)
            rules["weighting_rule"] = self.weighting
        if weighting is None:
            raise ConfigError(
                "weighting 'filter': this estimator computes no gain; name a weighting rule"
            )
        motion = self.motion.layer(scenario) if hasattr(self.motion, "layer") else None
        if motion is None:
            motion, rules["motion_rule"] = MotionLayer(no_motion, {}), self.motion
        return Layers(self.name, estimator, weighting, motion, **rules)

    def language(self, scenario: BaseScenario) -> tuple[list[object], KernelNumbers | None]:
        """Return the key of its messages, which only robots with an equal key understand: functions
        of the estimator and, in tasks with joint correction, its parameters."""
        layer = self.estimator.layer(scenario)
        numbers = layer.numbers if task_of(scenario).is_joint else None
        return functions_of(layer), numbers

    def build_team(self, world: World, seeds: Sequence[int], each: Sequence[Row]) -> RunningLayers:
        """Start a team; `each[world][robot]` is a controller, or None for robots of other teams."""
        return RunningLayers(world, seeds, each)

    def check_usable(self, scenario: BaseScenario) -> None:
        """Raise ConfigError or UnknownNameError if a layer does not support a scenario or lacks
        something it needs, such as a file; builds nothing."""
        self.check_supports(scenario)
        for part in (self.estimator, self.weighting, self.motion):
            if hasattr(part, "check_usable"):
                part.check_usable(scenario)

    def assumed(self, scenario: BaseScenario) -> str:
        """Return its assumptions in a scenario as a line of text; empty: none."""
        return ""

    def supports(self, scenario: BaseScenario) -> bool:
        """Return whether every layer supports the task of a scenario."""
        return self._unsupported(scenario) is None

    def check_supports(self, scenario: BaseScenario) -> None:
        """Raise ConfigError if a layer does not support the task of a scenario, or if faults change
        messages that the estimator cannot falsify."""
        layer = self._unsupported(scenario)
        if layer is not None:
            raise ConfigError(
                f"controller '{self.name}' does not run on '{scenario.name}': its {layer} is not"
                f" made for the task {task_of(scenario).name}; see swarm-forage list"
            )
        self.estimator.layer(scenario).check_falsifiable(self.name, scenario)

    def _unsupported(self, scenario: BaseScenario) -> str | None:
        """Return the first layer that does not support the task of a scenario, or None."""
        task = task_of(scenario)
        for layer, part in self.layers.items():
            if not {task.name, task.family} & {*getattr(part, "tasks", ("foraging",))}:
                return layer
        return None
