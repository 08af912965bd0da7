"""Where a learned policy is let into the ring: one class for each choice of `learn`.

    tick, listen | weigh | merge, aim | steer | tick ...

Each says what the policy sees and what it gives, and carries out one tick with it.
"""

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, Protocol

import numpy as np

from swarm_forage_env.arrays import Array, Bool, Float32
from swarm_forage_env.envs.bounds import Bounds
from swarm_forage_env.envs.layout import Field, Layout, Slot
from swarm_forage_env.envs.observation import (
    AREAS,
    SPEED,
    WHEELS,
    encounter_fields,
    heard_fields,
    readings_fields,
    situation_fields,
)
from swarm_forage_env.interface import WORDS, Command, ControllerRecipe, Feedback, Situation
from swarm_forage_env.loop import ControlLoop
from swarm_forage_env.registry import Registry
from swarm_forage_env.scenario import Scenario
from swarm_forage_env.world import World

G = tuple(Slot(f"g.{area}", "weight", 0.0, 1.0) for area in AREAS)
"""The weight of what was heard about each area; of no effect where no exchange just ended."""

SPEEDS = tuple(Slot(f"wheels.{side}", "of cruise speed", *SPEED) for side in WHEELS)

SPEAK = Slot("speak", "broadcast if > 0", *SPEED)

SAID = tuple(Slot(f"words.{word}", "as sent", *SPEED) for word in range(WORDS))


class Cut(Protocol):
    """A block of worlds with a policy in the place of a layer."""

    world: World
    action_layout: ClassVar[Layout]

    def reset(self, seeds: Sequence[int]) -> None:
        """Start every world anew, each from its seed."""
        ...

    def tick(self, action: Float32[Array, "rows numbers"]) -> Feedback:
        """One tick with this action of the policy, a row for each robot."""
        ...

    def fields(self, bounds: Bounds) -> dict[str, tuple[Field, ...]]:
        """The parts of the interface that the policy sees, and their fields."""
        ...

    @property
    def parts(self) -> Mapping[str, Any]:
        """Those parts as they stand."""
        ...

    @property
    def beliefs(self) -> Situation | None:
        """What the robots believe, if a hand-written estimator keeps beliefs."""
        ...


CUTS: Registry[Any] = Registry("layer to learn")
"""Cuts by the name that `learn` takes; made from scenario, recipe, seeds and physics."""

RESIDUAL_CUTS: Registry[Any] = Registry("layer to learn as a residual")
"""The same, where the policy's wheels are added to those of the hand-written motion."""

REACH = 2.0
"""Wheels that a residual of 1 adds: full speed back becomes full speed ahead."""


class _LayerCut:
    """A control loop of which some layers are the policy's."""

    def __init__(
        self, scenario: Scenario, recipe: ControllerRecipe, seeds: Sequence[int], physics: str
    ) -> None:
        """One world for each seed."""
        self._loop = ControlLoop(scenario, recipe, seeds, physics)
        self.world = self._loop.world

    def reset(self, seeds: Sequence[int]) -> None:
        """Start every world anew, each from its seed."""
        self._loop.reset(seeds)

    @property
    def parts(self) -> Mapping[str, Any]:
        """What either layer is shown."""
        estimator = self._loop.controller.estimator
        return {"encounter": estimator.encounter, "situation": estimator.situation}

    @property
    def beliefs(self) -> Situation | None:
        """What the estimator believes."""
        return self._loop.controller.estimator.situation

    @property
    def _n_slots(self) -> int:
        return int(self.world.feedback.heard.valid.shape[1])


@CUTS.register("weighting")
class WeightingCut(_LayerCut):
    """The policy sees each finished exchange and weighs it; all else is hand-written."""

    action_layout = Layout(G)

    def fields(self, bounds: Bounds) -> dict[str, tuple[Field, ...]]:
        """The encounter."""
        return {"encounter": encounter_fields(bounds)}

    def tick(self, action: Float32[Array, "rows numbers"]) -> Feedback:
        """One tick with the policy's weights."""
        feedback: Feedback = self._loop.step(g=action)
        return feedback


@CUTS.register("motion")
class MotionCut(_LayerCut):
    """The policy sees the situation and steers; all else is hand-written."""

    action_layout = Layout(SPEEDS)

    def fields(self, bounds: Bounds) -> dict[str, tuple[Field, ...]]:
        """The situation."""
        return {"situation": situation_fields(bounds, self._n_slots)}

    def tick(self, action: Float32[Array, "rows numbers"]) -> Feedback:
        """One tick with the policy's wheels."""
        feedback: Feedback = self._loop.step(wheels=action)
        return feedback


@CUTS.register("both")
class BothCut(_LayerCut):
    """The policy weighs and steers; estimates and messages are hand-written."""

    action_layout = Layout(G + SPEEDS)

    def fields(self, bounds: Bounds) -> dict[str, tuple[Field, ...]]:
        """The encounter, then the situation."""
        situation = situation_fields(bounds, self._n_slots)
        return {"encounter": encounter_fields(bounds), "situation": situation}

    def tick(self, action: Float32[Array, "rows numbers"]) -> Feedback:
        """One tick with the policy's weights and wheels."""
        g, wheels = np.split(action, [len(G)], axis=1)
        feedback: Feedback = self._loop.step(np.ascontiguousarray(g), np.ascontiguousarray(wheels))
        return feedback


@RESIDUAL_CUTS.register("motion")
class ResidualMotionCut(MotionCut):
    """The policy corrects what the hand-written motion does."""

    def tick(self, action: Float32[Array, "rows 2"]) -> Feedback:
        """One tick with the corrected wheels."""
        return super().tick(_corrected_by(action, self._loop))


@RESIDUAL_CUTS.register("both")
class ResidualBothCut(BothCut):
    """The policy weighs, and corrects what the hand-written motion does."""

    def tick(self, action: Float32[Array, "rows 4"]) -> Feedback:
        """One tick with the policy's weights and the corrected wheels."""
        wheels = _corrected_by(action[:, len(G) :], self._loop)
        return super().tick(np.concatenate([action[:, : len(G)], wheels], axis=1))


def corrected(
    own: Float32[Array, "rows 2"],
    residual: Float32[Array, "rows 2"],
    talking: Bool[Array, " rows"],
) -> Float32[Array, "rows 2"]:
    """Wheels of a hand-written motion, corrected: clip(own + REACH residual, -1, 1).

    A robot that is talking does what the hand-written motion says, as communication takes
    control of the motors (TR, Section 5.2).

    Source: Silver2018, Residual Policy Learning (arXiv:1812.06298).
    """
    wheels = np.clip(own + np.float32(REACH) * residual, -1.0, 1.0)
    return np.where(talking[:, None], own, wheels)


def _corrected_by(residual: Float32[Array, "rows 2"], loop: ControlLoop) -> Array:
    situation = loop.controller.estimator.situation
    return corrected(loop.controller.motion(situation), residual, situation.talking)


@CUTS.register("everything")
class EverythingCut:
    """The policy sees raw readings and messages, steers and speaks; no controller runs.

    Nobody reports itself lost, and nobody's beliefs are known: whoever has visited an area
    counts as knowing it.
    """

    action_layout = Layout((*SPEEDS, SPEAK, *SAID))
    beliefs = None

    def __init__(
        self, scenario: Scenario, recipe: ControllerRecipe, seeds: Sequence[int], physics: str
    ) -> None:
        """One world for each seed; the recipe is not used."""
        self.world = World(scenario, seeds, physics)
        self._cruise = scenario.robot.cruise_speed
        self._nobody = np.zeros(self.world.rows, np.bool_)

    def reset(self, seeds: Sequence[int]) -> None:
        """Start every world anew, each from its seed."""
        self.world.reset(seeds)

    def fields(self, bounds: Bounds) -> dict[str, tuple[Field, ...]]:
        """The readings, then the messages."""
        n_slots = int(self.world.feedback.heard.valid.shape[1])
        return {"readings": readings_fields(bounds), "heard": heard_fields(bounds, n_slots)}

    @property
    def parts(self) -> Mapping[str, Any]:
        """What the last tick gave back."""
        feedback = self.world.feedback
        return {"readings": feedback.readings, "heard": feedback.heard}

    def tick(self, action: Float32[Array, "rows numbers"]) -> Feedback:
        """One tick with the policy's wheels and words."""
        wheels = action[:, :2].astype(np.float64) * self._cruise
        words, speaking = action[:, 3:], action[:, 2] > 0.0
        visited = self.world.state.first_visit >= 0
        return self.world.tick(Command(wheels, words, speaking, self._nobody, visited))
