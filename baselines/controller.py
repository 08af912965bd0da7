"""A named controller: estimator + weighting + motion, each with its parameters."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from baselines.composition import Row, functions_of
from baselines.estimators import ESTIMATORS
from baselines.motion import MOTIONS
from baselines.running import RunningLayers
from baselines.weighting import WEIGHTING_RULES
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.interface import KernelNumbers
from swarm_forage_env.parameters import Part, leaves, override, resolve, validated
from swarm_forage_env.task import World, task_of

REGISTRIES = {"estimator": ESTIMATORS, "weighting": WEIGHTING_RULES, "motion": MOTIONS}
"""Where the parts of each layer are registered."""


@dataclass(frozen=True)
class LayeredController:
    """A controller of three layers.

    A layer is compiled if its parameters have a method `layer`, and otherwise a rule of NumPy:
    a weighting is called, or what its method `start` gives, and of a motion what `start` gives;
    so too of a motion whose `layer` is None in a scenario.
    """

    name: str
    estimator: Any
    weighting: Any
    motion: Any

    @property
    def layers(self) -> dict[str, Part]:
        """The parameters of each layer."""
        return {"estimator": self.estimator, "weighting": self.weighting, "motion": self.motion}

    @property
    def parameters(self) -> dict[str, Any]:
        """Every parameter by dotted name."""
        return leaves({layer: part.model_dump() for layer, part in self.layers.items()})

    @property
    def layer_names(self) -> dict[str, str]:
        """The name of each layer: that of its part in the registry, or else of its class."""
        classes = {layer: type(part) for layer, part in self.layers.items()}
        return {
            layer: REGISTRIES[layer].name_of(each) or each.__name__
            for layer, each in classes.items()
        }

    @property
    def talks(self) -> bool:
        """Whether its robots tell each other anything to weigh."""
        return bool(getattr(self.estimator, "speaks", True))

    def with_parameters(self, values: Mapping[str, object]) -> "LayeredController":
        """The same controller with some parameters changed, named as `beta` or `weighting.beta`.

        A layer's name chooses another registered part, which keeps the parameters that both have:
        `estimator=dead_reckoning`. UnknownNameError for an unknown name, ConfigError for a value
        that does not fit or a missing file.
        """
        chosen: dict[str, Any] = {
            layer: name for layer, name in values.items() if layer in REGISTRIES
        }
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
            if hasattr(part, "check_usable"):
                part.check_usable()
        return replace(changed, **parts)

    def _with_layers(self, names: Mapping[str, str]) -> "LayeredController":
        """The same controller with other registered parts for some layers."""
        parts: dict[str, Any] = {}
        for layer, name in names.items():
            part, old = REGISTRIES[layer][name], self.layers[layer].model_dump()
            kept = {field: value for field, value in old.items() if field in part.model_fields}
            parts[layer] = validated(part, kept)
        return replace(self, **parts)

    def build(
        self, world: World, seeds: Sequence[int], each: Sequence["LayeredController"]
    ) -> RunningLayers:
        """The running controller of a block of worlds, `each` with a controller of its own numbers.

        ConfigError if a layer does not support such a world.
        """
        self.check_supports(world.scenario)
        return RunningLayers(world, seeds, [[own] * world.n_robots for own in each])

    def language(self, scenario: Part) -> tuple[list[object], KernelNumbers | None]:
        """What its robots understand: estimators of one kind; of one kind and equal numbers where
        estimates are corrected jointly."""
        layer = self.estimator.layer(scenario)
        numbers = layer.numbers if task_of(scenario).is_joint else None
        return functions_of(layer), numbers

    def build_team(self, world: World, seeds: Sequence[int], each: Sequence[Row]) -> RunningLayers:
        """The running controller of some robots, worlds by robots; None for one of another's."""
        return RunningLayers(world, seeds, each)

    def check_usable(self, scenario: Part) -> None:
        """ConfigError or UnknownNameError if a layer is not made for such a world, or lacks what
        it needs there: found out before anything is built."""
        self.check_supports(scenario)
        for part in self.layers.values():
            if hasattr(part, "check_usable"):
                part.check_usable(scenario)

    def assumed(self, scenario: Part) -> str:
        """What is taken for granted of it in a scenario, in a line for its user; empty: nothing."""
        return ""

    def supports(self, scenario: Part) -> bool:
        """Whether every layer is made for the world of this scenario."""
        return self._unsupported(scenario) is None

    def check_supports(self, scenario: Any) -> None:  # noqa: ANN401 of any task
        """ConfigError if a layer is not made for the world of this scenario, or cannot tell lies
        where there are liars."""
        layer = self._unsupported(scenario)
        if layer is not None:
            raise ConfigError(
                f"controller '{self.name}' does not run on '{scenario.name}': its {layer} is not"
                f" made for the task {task_of(scenario).name}; see swarm-forage list"
            )
        self.estimator.layer(scenario).check_falsifiable(self.name, scenario)

    def _unsupported(self, scenario: Part) -> str | None:
        """The first layer that is not made for the world of this scenario."""
        task = task_of(scenario)
        for layer, part in self.layers.items():
            if not {task.name, task.family} & {*getattr(part, "tasks", ("foraging",))}:
                return layer
        return None
