"""A named controller: estimator + weighting + motion, each with its parameters."""

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
    resolve,
    validated,
)
from swarm_forage_env.task import World, task_of

REGISTRIES = {"estimator": ESTIMATORS, "weighting": WEIGHTING_RULES, "motion": MOTIONS}
"""Where the parts of each layer are registered."""


@dataclass(frozen=True)
class LayeredController:
    """A controller of three layers, which can be named, changed and run.

    A layer is compiled if its parameters have a method `layer` that does not return None. Otherwise
    it is a rule in NumPy: a weighting is called, a motion is what its method `start` returns.

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
        """The parameters of each layer."""
        return {"estimator": self.estimator, "weighting": self.weighting, "motion": self.motion}

    @property
    def parameters(self) -> dict[str, object]:
        """Every parameter by dotted name."""
        return leaves({layer: part.model_dump() for layer, part in self.layers.items()})

    @property
    def layer_names(self) -> dict[str, str]:
        """The name of each layer: that of its part in the registry, or else of its class."""
        return {
            layer: REGISTRIES[layer].name_of(type(part)) or type(part).__name__
            for layer, part in self.layers.items()
        }

    @property
    def talks(self) -> bool:
        """Its robots tell each other what a weighting can weigh."""
        return bool(getattr(self.estimator, "speaks", True))

    def with_parameters(self, values: Mapping[str, object]) -> "LayeredController":
        """The same controller with some parameters changed, named as `beta` or `weighting.beta`.

        A layer's name chooses another registered part, which keeps the parameters that both have:
        `estimator=dead_reckoning`. UnknownNameError for an unknown name, ConfigError for a value
        that does not fit or a missing file.
        """
        chosen = {layer: str(name) for layer, name in values.items() if layer in REGISTRIES}
        changed = self._with_layers(chosen)
        changes: dict[str, dict[str, object]] = {}
        for name, value in values.items():
            if name not in chosen:
                path = resolve(name, changed.parameters, f"parameter of {self.name}")
                layer, _, field = path.partition(".")
                changes.setdefault(layer, {})[field] = value
        parts: dict[str, Any] = {
            layer: override(changed.layers[layer], to) for layer, to in changes.items()
        }
        for part in parts.values():
            if hasattr(part, "check_usable"):  # it needs more than numbers, as a policy's file
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
        """The three layers in a scenario; ConfigError for a part that does not fit there."""
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
                "weighting 'filter': this estimator has no gain of its own; name a rule"
            )
        motion = self.motion.layer(scenario) if hasattr(self.motion, "layer") else None
        if motion is None:
            motion, rules["motion_rule"] = MotionLayer(no_motion, {}), self.motion
        return Layers(self.name, estimator, weighting, motion, **rules)

    def language(self, scenario: BaseScenario) -> tuple[list[object], KernelNumbers | None]:
        """What its robots understand: messages of estimators with the same functions and, where
        estimates are corrected jointly, equal numbers."""
        layer = self.estimator.layer(scenario)
        numbers = layer.numbers if task_of(scenario).is_joint else None
        return functions_of(layer), numbers

    def build_team(self, world: World, seeds: Sequence[int], each: Sequence[Row]) -> RunningLayers:
        """The running controller of a team, worlds by robots; None for robots of other teams."""
        return RunningLayers(world, seeds, each)

    def check_usable(self, scenario: BaseScenario) -> None:
        """ConfigError or UnknownNameError if a layer does not support such a world, or lacks
        something that it needs there; nothing is built."""
        self.check_supports(scenario)
        for part in (self.estimator, self.weighting, self.motion):
            if hasattr(part, "check_usable"):
                part.check_usable(scenario)

    def assumed(self, scenario: BaseScenario) -> str:
        """Its assumptions in a scenario, as a line for the user; empty: none."""
        return ""

    def supports(self, scenario: BaseScenario) -> bool:
        """Every layer is made for the world of this scenario."""
        return self._unsupported(scenario) is None

    def check_supports(self, scenario: BaseScenario) -> None:
        """ConfigError if a layer is not made for the world of this scenario, or if faults change
        messages that the estimator cannot falsify."""
        layer = self._unsupported(scenario)
        if layer is not None:
            raise ConfigError(
                f"controller '{self.name}' does not run on '{scenario.name}': its {layer} is not"
                f" made for the task {task_of(scenario).name}; see swarm-forage list"
            )
        self.estimator.layer(scenario).check_falsifiable(self.name, scenario)

    def _unsupported(self, scenario: BaseScenario) -> str | None:
        """The first layer that is not made for the world of this scenario."""
        task = task_of(scenario)
        for layer, part in self.layers.items():
            if not {task.name, task.family} & {*getattr(part, "tasks", ("foraging",))}:
                return layer
        return None
