"""Policy interface: what a policy that replaces a layer observes, and what it gives."""

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
    """A form in which a policy steers: two numbers, which become a command."""

    layout: Layout
    """What the two numbers are, each in [-1, 1]."""
    choices: tuple[tuple[float, float], ...]
    """The discrete actions in this form, by default."""
    command: Kernel | None = None
    """The command of two numbers, under a sharpest turn; None: they are the command."""
    is_course: bool = False
    """The second number is how far off the course to steer, and reflexes are kept."""


SILENT: Float32[Array, "1 0"] = np.zeros((1, 0), np.float32)
"""What is said by a policy that says nothing."""


@dataclass(frozen=True)
class PolicyInterface:
    """What `learn=` chooses: what a policy observes and gives, and the layers that it replaces."""

    observes: tuple[FieldPath, ...]
    """The fields of records that are shown, in order."""
    gives: tuple[FieldPath, ...]
    """The fields of records that an action is written to, in order."""
    replaces: tuple[str, ...]
    """The layers that the policy replaces: `weighting`, `motion`."""
    sizes: Callable[..., Sizes] = lambda scenario: {}
    """Sizes of the named axes of these fields in a scenario."""
    decision_period: int = 1
    """Ticks for which an action is held, by default."""
    can_correct: bool = False
    """It can be learned as a correction of the hand-written motion."""
    said: Float32[Array, "choices numbers"] = field(default_factory=lambda: SILENT)
    """What can be said in a discrete action: the rest of the numbers, a row for each choice."""
    target: str | None = None
    """The observed vector whose direction is observed too where observations are normalised."""
    walk: tuple[FieldPath, ...] = ()
    """The course of the robot's random walk, which is observed instead of that direction
    where there is none; then the motion has reflexes that can be kept, too."""

    def layout(self, scenario: BaseScenario, has_walk: bool) -> FieldLayout:
        """What each number of an observation is in a scenario."""
        fields = self.observes + (self.walk if has_walk else ())
        return layout_of(fields, self.sizes(scenario), scenario)

    @property
    def action(self) -> FieldLayout:
        """What each number of an action is, as the layers take it: the same in all scenarios."""
        return layout_of(self.gives, {}, None)

    @property
    def n_weights(self) -> int:
        """How many numbers of an action are weights in [0, 1]; they come first."""
        return len(layout_of([each for each in self.gives if each.name == "weight"], {}, None))
