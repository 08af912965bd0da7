"""Controller = estimator + weighting + motion."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.interface import Command, Estimator, Feedback, Motion, Weighting
from swarm_forage_env.scenario import Part, Scenario, leaves, override, resolve
from swarm_forage_env.waypoints_interface import WaypointCommand, WaypointFeedback
from swarm_forage_env.waypoints_scenario import AnyScenario, WaypointsScenario


class Layers:
    """Three layers, run on all rows of a block of worlds at once.

    Both the weight and the wheels of a tick are decided from what the robot knows after
    listening; what was heard is merged afterwards, and steers from the next tick on. So one
    observation holds all that either layer, or both, are shown.
    """

    def __init__(self, estimator: Any, weighting: Any, motion: Any, n_robots: int) -> None:  # noqa: ANN401 of either world
        """Put the running layers together."""
        self.estimator = estimator
        self.weighting = weighting
        self.motion = motion
        self._n_robots = n_robots
        self._wheels: Float32[Array, "rows 2"] | None = None

    def observe(self, feedback: Feedback | WaypointFeedback) -> None:
        """Take in what the world gave back; the layers' inputs are ready afterwards."""
        if self._wheels is None:
            self._wheels = np.zeros((len(feedback.reward), 2), np.float32)
        self.estimator.observe(feedback.readings, feedback.heard, self._wheels)

    def command(
        self,
        g: Float32[Array, "rows areas"] | None = None,
        wheels: Float32[Array, "rows 2"] | None = None,
    ) -> Any:  # noqa: ANN401 the command of its world
        """The next command; a weight or wheels from outside take the place of that layer."""
        encounter = self.estimator.encounter
        if wheels is None:
            wheels = self.motion(self.estimator.situation)
        if encounter.valid.any():
            weights = self.weighting(encounter) if g is None else g
            self.estimator.merge(weights, self.weighting.heard_p_share)
        self._wheels = wheels
        return self._told(wheels)

    def act(self, feedback: Feedback | WaypointFeedback) -> Any:  # noqa: ANN401
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

    def _told(self, wheels: Float32[Array, "rows 2"]) -> Any:  # noqa: ANN401 as above
        """What the robots are told, with these wheels."""
        raise NotImplementedError


class Controller(Layers):
    """The layers of robots that forage."""

    def __init__(
        self, estimator: Estimator, weighting: Weighting, motion: Motion, scenario: Scenario
    ) -> None:
        """Put the running layers together."""
        super().__init__(estimator, weighting, motion, scenario.task.n_robots)
        self._cruise = scenario.robot.cruise_speed

    def _told(self, wheels: Float32[Array, "rows 2"]) -> Command:
        """These wheels, and what the estimators say."""
        words, speaking, lost = self.estimator.say()
        known = self.estimator.situation.known
        return Command(wheels.astype(np.float64) * self._cruise, words, speaking, lost, known)


class WaypointController(Layers):
    """The layers of robots that visit waypoints: a pull takes the place of the wheels."""

    def __init__(
        self,
        estimator: Any,  # noqa: ANN401 as Layers
        weighting: Any,  # noqa: ANN401
        motion: Any,  # noqa: ANN401
        scenario: WaypointsScenario,
    ) -> None:
        """Put the running layers together."""
        super().__init__(estimator, weighting, motion, scenario.task.n_robots)

    def _told(self, wheels: Float32[Array, "rows 2"]) -> WaypointCommand:
        """This pull, and who claims its goal."""
        return WaypointCommand(wheels, self.estimator.claim)


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

    @property
    def message_path(self) -> float:
        """What a message adds to the p that it tells [m]."""
        return float(getattr(self.estimator, "message_path", 0.0))

    @property
    def talks(self) -> bool:
        """Whether its robots tell each other anything to weigh."""
        return bool(getattr(self.estimator, "speaks", True))

    def with_parameters(self, values: Mapping[str, Any]) -> "Recipe":
        """The same recipe with some parameters changed, named as `beta` or `weighting.beta`.

        UnknownNameError for a name that stands for nothing, ConfigError for a value that does not
        fit; so too for a file that a changed layer needs.
        """
        changes: dict[str, dict[str, Any]] = {}
        for name, value in values.items():
            path = resolve(name, self.parameters, f"parameter of {self.name}")
            layer, _, field = path.partition(".")
            changes.setdefault(layer, {})[field] = value
        parts: dict[str, Any] = {
            layer: override(self.layers[layer], to) for layer, to in changes.items()
        }
        for part in parts.values():
            if hasattr(part, "check_usable"):
                part.check_usable()
        return replace(self, **parts)

    def build(self, scenario: AnyScenario, seeds: Sequence[int]) -> Any:  # noqa: ANN401 of its world
        """The running controller for a block of worlds, one for each seed.

        ConfigError if a layer is not made for such a world.
        """
        self.check_made_for(scenario)
        estimator = self.estimator.start(scenario, len(seeds))
        motion = self.motion.start(scenario, seeds)
        weighting = self.weighting
        if hasattr(weighting, "beside"):
            weighting = weighting.beside(estimator)
        if isinstance(scenario, WaypointsScenario):
            return WaypointController(estimator, weighting, motion, scenario)
        return Controller(estimator, weighting, motion, scenario)

    def check_usable(self, scenario: AnyScenario) -> None:
        """ConfigError or UnknownNameError if a layer is not made for such a world, or lacks what
        it needs there: found out before anything is built."""
        self.check_made_for(scenario)
        for part in self.layers.values():
            if hasattr(part, "check_usable"):
                part.check_usable(scenario)

    def runs_on(self, scenario: AnyScenario) -> bool:
        """Whether every layer is made for the world of this scenario."""
        return all(isinstance(scenario, made_for(part)) for part in self.layers.values())

    def check_made_for(self, scenario: AnyScenario) -> None:
        """ConfigError if a layer is not made for the world of this scenario."""
        if self.runs_on(scenario):
            return
        task = "visits waypoints" if isinstance(scenario, WaypointsScenario) else "forages"
        layer = next(
            name for name, part in self.layers.items() if not isinstance(scenario, made_for(part))
        )
        raise ConfigError(
            f"controller '{self.name}' does not run on '{scenario.name}': a swarm {task} there, and"
            f" its {layer} is not made for that; see swarm-forage list"
        )


def made_for(part: Any) -> tuple[type[Part], ...]:  # noqa: ANN401 a layer's parameters
    """The kinds of scenarios that a layer runs on: foraging, unless it says otherwise."""
    worlds: tuple[type[Part], ...] = getattr(part, "worlds", (Scenario,))
    return worlds
