"""Policy interface: what a policy in the place of a layer observes, and what it gives."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from swarm_forage_env.arrays import Array, Float32, Int64
from swarm_forage_env.interface import Kernel
from swarm_forage_env.spaces import FeatureGroup, Layout, ObservationLayout

Groups = Mapping[str, tuple[FeatureGroup, ...]]

Index = slice | Int64[Array, " learners"]
"""Which robots learn: a slice that takes all, or their numbers."""

ActOn = Callable[[Any, Any, Index, Float32[Array, "worlds learners numbers"]], None]
"""Writes the actions of the learners of every world; of world, controller, which robots learn, and
their actions."""


@dataclass(frozen=True)
class Steering:
    """A form in which a policy steers: two numbers, and the command that they stand for."""

    layout: Layout
    """What the two numbers are, each in [-1, 1]."""

    choices: tuple[tuple[float, float], ...]
    """The discrete actions in this form, where no other number of them is asked for."""

    command: Kernel | None = None
    """The command that two numbers stand for, under a sharpest turn; None: they are the command."""


SILENT: Float32[Array, "1 0"] = np.zeros((1, 0), np.float32)
"""What is said by a policy that says nothing."""


@dataclass(frozen=True)
class PolicyOnGrid:
    """What a policy observes and gives, as functions of one robot."""

    show: Kernel
    """Writes an observation; of the robot, the minds of its world's robots, which of them is its
    own, message slots and output."""

    put: Kernel
    """Writes an action as the layers take it; of the robot, its mind and the numbers."""


@dataclass(frozen=True)
class PolicyInterface:
    """What `learn=` chooses: the parts that a policy observes, and the layers that it replaces."""

    action: Layout
    """What each number of an action is."""

    features: Callable[[Any], Groups]
    """The parts of an observation, in a scenario."""

    observe: Callable[[Any, Any, Float32[Array, "worlds robots numbers"]], None]
    """Writes the observations of all robots to the first numbers of a row of the output, which may
    be longer; of world, controller and output."""

    act: ActOn
    """Writes the actions of the learners."""

    replaces: tuple[str, ...]
    """The layers that the policy takes the place of: `weighting`, `motion`."""

    inputs: Mapping[str, type[Any]]
    """What each part is as arrays, for code that reads observations by name."""

    on_grid: PolicyOnGrid | None = None
    """How a GPU runs the policy; None: a CPU only."""

    decision_period: int = 1
    """Ticks for which an action is held where nothing else is asked for."""

    n_weights: int = 0
    """How many numbers of an action are weights in [0, 1]; they come first."""

    is_steering: bool = False
    """The two numbers that follow are the command of the motion."""

    said: Float32[Array, "choices numbers"] = field(default_factory=lambda: SILENT)
    """What can be said in a discrete action: the rest of the numbers, a row for each choice."""

    target: str | None = None
    """The observed vector whose direction is observed too where observations are normalised."""

    def layout(self, scenario: Any) -> ObservationLayout:  # noqa: ANN401 of its task
        """What each number of an observation is, in a scenario."""
        return ObservationLayout(self.features(scenario), self.inputs)
