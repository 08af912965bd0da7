"""Policy interface: observation and action of a policy that replaces layers."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.interface import Kernel
from swarm_forage_env.observed_fields import FieldLayout, FieldPath, Sizes, layout_of
from swarm_forage_env.parameters import BaseScenario
from swarm_forage_env.spaces import Layout


@dataclass(frozen=True)
class Steering:
    """A form of steering: two elements of an action, which are converted to a command."""

    layout: Layout
    """Features of the two elements, each in [-1, 1]."""
    choices: tuple[tuple[float, float], ...]
    """Default discrete actions in this form."""
    command: Kernel | None = None
    """Computes the command from both elements and the sharpest turn; None: they are the command."""
    is_course: bool = False
    """Whether the second element is an angle off the course; reflexes then stay active."""


SILENT: Float32[Array, "1 0"] = np.zeros((1, 0), np.float32)
"""Messages of a policy that sends none."""


@dataclass(frozen=True)
class PolicyInterface:
    """A choice of `learn=`: the observation and action of a policy, and the layers it replaces."""

    observes: tuple[FieldPath, ...]
    """Observed fields of records, in order."""
    gives: tuple[FieldPath, ...]
    """Fields of records to which an action is written, in order."""
    replaces: tuple[str, ...]
    """Layers that the policy replaces: `weighting`, `motion`."""
    sizes: Callable[..., Sizes] = lambda scenario: {}
    """Returns the sizes of the named axes of these fields in a scenario."""
    decision_period: int = 1
    """Default number of ticks for which an action is held."""
    can_correct: bool = False
    """Whether it can be learned as a correction of the hand-written motion."""
    messages: Float32[Array, "choices numbers"] = field(default_factory=lambda: SILENT)
    """Messages in discrete actions: the last elements of the action, a row for each choice."""
    target: str | None = None
    """Observed vector whose direction is also observed if observations are normalised."""
    walk: tuple[FieldPath, ...] = ()
    """Course of the robot's random walk, observed instead of that direction where there is none. If
    given, the motion also has reflexes that can be kept."""

    def layout(self, scenario: BaseScenario, has_walk: bool) -> FieldLayout:
        """Return the layout of an observation in a scenario."""
        fields = self.observes + (self.walk if has_walk else ())
        return layout_of(fields, self.sizes(scenario), scenario)

    @property
    def action(self) -> FieldLayout:
        """Layout of an action as the layers receive it; it is the same in all scenarios."""
        return layout_of(self.gives, {}, None)

    @property
    def n_weights(self) -> int:
        """Number of elements of an action that are weights in [0, 1]; they come first."""
        return len(layout_of([each for each in self.gives if each.name == "weight"], {}, None))
