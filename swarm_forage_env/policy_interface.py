"""Policy interface: what a policy in the place of a layer observes, and what it gives."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.spaces import FeatureGroup, Layout, ObservationLayout

Groups = Mapping[str, tuple[FeatureGroup, ...]]

ActOn = Callable[[Any, Any, Float32[Array, "worlds learners numbers"]], None]
"""Writes the actions of the learners of every world, the first robots; of world, controller and
actions."""


@dataclass(frozen=True)
class PolicyInterface:
    """What `learn=` chooses: the parts that a policy observes, and the layers that it replaces."""

    action: Layout
    """What each number of an action is."""

    features: Callable[[Any], Groups]
    """The parts of an observation, from the bounds of a scenario."""

    observe: Callable[[Any, Any, Float32[Array, "worlds robots numbers"]], None]
    """Writes the observations of all robots; of world, controller and output."""

    act: ActOn
    """Writes the actions of the learners."""

    replaces: tuple[str, ...]
    """The layers that the policy takes the place of: `weighting`, `motion`."""

    inputs: Mapping[str, type[Any]]
    """What each part is as arrays, for code that reads observations by name."""

    def layout(self, bounds: Any) -> ObservationLayout:  # noqa: ANN401 of its task
        """What each number of an observation is, for a scenario of these bounds."""
        return ObservationLayout(self.features(bounds), self.inputs)
