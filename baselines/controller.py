"""Controller = estimator + weighting + motion."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.interface import Command, Estimator, Feedback, Motion, Weighting
from swarm_forage_env.scenario import Part, Scenario, leaves, override, resolve


class Controller:
    """Three layers, run on all rows of a block of worlds at once.

    Both the weight and the wheels of a tick are decided from what the robot knows after
    listening; what was heard is merged afterwards, and steers from the next tick on. So one
    observation holds all that either layer, or both, are shown.
    """

    def __init__(
        self, estimator: Estimator, weighting: Weighting, motion: Motion, scenario: Scenario
    ) -> None:
        """Put the running layers together."""
        self.estimator = estimator
        self.weighting = weighting
        self.motion = motion
        self._cruise = scenario.robot.cruise_speed
        self._n_robots = scenario.task.n_robots
        self._wheels: Float32[Array, "rows 2"] | None = None

    def observe(self, feedback: Feedback) -> None:
        """Take in what the world gave back; the layers' inputs are ready afterwards."""
        if self._wheels is None:
            self._wheels = np.zeros((len(feedback.reward), 2), np.float32)
        self.estimator.observe(feedback.readings, feedback.heard, self._wheels)

    def command(
        self,
        g: Float32[Array, "rows areas"] | None = None,
        wheels: Float32[Array, "rows 2"] | None = None,
    ) -> Command:
        """The next command; a weight or wheels from outside take the place of that layer."""
        encounter = self.estimator.encounter
        if wheels is None:
            wheels = self.motion(self.estimator.situation)
        if encounter.valid.any():
            weights = self.weighting(encounter) if g is None else g
            self.estimator.merge(weights, self.weighting.heard_p_share)
        self._wheels = wheels
        words, speaking, lost = self.estimator.say()
        return Command(wheels.astype(np.float64) * self._cruise, words, speaking, lost)

    def act(self, feedback: Feedback) -> Command:
        """One tick of the whole controller."""
        self.observe(feedback)
        return self.command()

    def reset(self, world: int, seed: int) -> None:
        """Forget everything about one world."""
        self.estimator.reset(world, seed)
        self.motion.reset(world, seed)
        if self._wheels is not None:
            self._wheels = self._wheels.copy()  # it may be the caller's
            self._wheels[world * self._n_robots : (world + 1) * self._n_robots] = 0.0


@dataclass(frozen=True)
class Recipe:
    """A named controller: one choice for each layer, with parameters."""

    name: str
    estimator: Any
    weighting: Any
    motion: Any

    @property
    def layers(self) -> dict[str, Part]:
        """The parameters of each layer."""
        return {
            "estimator": self.estimator,
            "weighting": self.weighting,
            "motion": self.motion,
        }

    @property
    def parameters(self) -> dict[str, Any]:
        """Every parameter by dotted name."""
        return leaves({layer: part.model_dump() for layer, part in self.layers.items()})

    def with_parameters(self, values: Mapping[str, Any]) -> "Recipe":
        """The same recipe with some parameters changed, named as `beta` or `weighting.beta`."""
        changes: dict[str, dict[str, Any]] = {}
        for name, value in values.items():
            path = resolve(name, self.parameters, f"parameter of {self.name}")
            layer, _, field = path.partition(".")
            changes.setdefault(layer, {})[field] = value
        parts: dict[str, Any] = {
            layer: override(self.layers[layer], to) for layer, to in changes.items()
        }
        return replace(self, **parts)

    def build(self, scenario: Scenario, seeds: Sequence[int]) -> Controller:
        """The running controller for a block of worlds, one for each seed."""
        return Controller(
            self.estimator.start(scenario, len(seeds)),
            self.weighting,
            self.motion.start(scenario, seeds),
            scenario,
        )
