"""The door to the ground truth, for references only.

A reference is a recipe with `build_knowing`: the control loop hands it a `GroundTruth`. An
ordinary recipe is never handed one, and no environment takes a reference, so that nothing of
the truth reaches an observation.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol, TypeGuard

from swarm_forage_env.arrays import Array, Float64, checked
from swarm_forage_env.interface import Controller, ControllerRecipe
from swarm_forage_env.scenario import Scenario


@checked
@dataclass(frozen=True, slots=True)
class GroundTruth:
    """What is true in a block of worlds, as it stands at any time; read-only."""

    pose: Float64[Array, "rows 3"]
    """x, y [m] and heading [rad] of each robot in the world frame."""

    areas: Float64[Array, "areas 2"]
    """Centres of nest and prey, world frame [m]."""


class ReferenceRecipe(ControllerRecipe, Protocol):
    """A recipe that declares itself privileged."""

    def build_knowing(
        self, scenario: Scenario, seeds: Sequence[int], truth: GroundTruth
    ) -> Controller:
        """The running controller for a block of worlds of which this is true."""
        ...


def is_reference(recipe: Any) -> TypeGuard[ReferenceRecipe]:  # noqa: ANN401 whatever was given
    """The recipe wants the ground truth."""
    return hasattr(recipe, "build_knowing")


def read_only(array: Array) -> Array:
    """A view that follows the array and cannot be written to."""
    view = array.view()
    view.flags.writeable = False
    return view
