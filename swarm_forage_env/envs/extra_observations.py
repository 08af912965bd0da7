"""Additional observations: the protocol of user-defined ones, and those with a name."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from swarm_forage_env.arrays import Array, Bool, Float32, Float64, Int64, UInt64
from swarm_forage_env.compiler import inlined
from swarm_forage_env.parameters import BaseScenario
from swarm_forage_env.random_streams import draw_rows
from swarm_forage_env.registry import Registry
from swarm_forage_env.spaces import Feature, Layout


@dataclass(frozen=True)
class ObservationContext:
    """Inputs of a user-defined observation: the current records of a block of worlds."""

    robots: Array
    """Records of the robots, shape (worlds, robots): ground truth, readings, received messages."""
    worlds: Array
    """Records of the worlds: clock and parameters."""
    minds: Array | None
    """States of the estimators, shape (worlds, robots); None if no hand-written estimator runs."""
    time_left: Float64[Array, " worlds"]
    """Remaining share of the episode."""
    last_action: Float32[Array, "worlds robots numbers"]
    """Last layer inputs; zeros before the first action and for robots that do not learn."""
    streams: UInt64[Array, "worlds robots"]
    """Random stream of each robot for observations only; it restarts with each episode."""
    is_observed: Bool[Array, " worlds"]
    """Whether each world is observed now. The streams of the other worlds do not advance, and what
    is written of them is ignored."""

    def normal(self, n: int) -> Float64[Array, "worlds robots n"]:
        """Draw standard normal values, fixed by the seed; zeros in worlds not observed."""
        return self._drawn(n, is_normal=True)

    def uniform(self, n: int) -> Float64[Array, "worlds robots n"]:
        """Draw uniform values in [0, 1), otherwise as `normal`."""
        return self._drawn(n, is_normal=False)

    def _drawn(self, n: int, is_normal: bool) -> Float64[Array, "worlds robots n"]:
        out = np.zeros((*self.streams.shape, n))
        for world in np.flatnonzero(self.is_observed):
            draw_rows(self.streams[world], out[world], is_normal)
        return out


@runtime_checkable
class Observation(Protocol):
    """User-defined observation: some features of every robot."""

    def features(self, scenario: BaseScenario, agents: Sequence[str]) -> Sequence[Feature]:
        """Return the features in a scenario with these robots."""

    def write(
        self, context: ObservationContext, out: Float32[Array, "worlds robots numbers"]
    ) -> None:
        """Write the features of every robot to `out`."""


TIME_LEFT, ROBOT_ID, ONE_HOT, PREVIOUS_ACTION = range(4)
"""Kinds of named additions."""


@inlined
def write_additions(
    additions: Int64[Array, "additions 2"],
    i: int,
    n_robots: int,
    time_left: float,
    last_action: Float32[Array, " numbers"],
    row: Float32[Array, " numbers"],
) -> None:
    """Write the additions of robot i, each given by its kind and its first index in the row."""
    for each in range(additions.shape[0]):
        kind, out = additions[each, 0], row[additions[each, 1] :]
        if kind == TIME_LEFT:
            out[0] = time_left
        elif kind == ROBOT_ID:
            out[0] = i / max(n_robots - 1, 1)
        elif kind == ONE_HOT:
            for k in range(n_robots):
                out[k] = 1.0 if k == i else 0.0
        else:
            for k in range(last_action.shape[0]):
                out[k] = last_action[k]


@dataclass(frozen=True)
class RowObservation:
    """Named addition, which `write_additions` writes."""

    kind: int
    """TIME_LEFT, ROBOT_ID, ONE_HOT or PREVIOUS_ACTION."""
    features_of: Callable[[Sequence[str]], Sequence[Feature]]
    """Returns the features in a world of these robots."""

    def features(self, scenario: object, agents: Sequence[str]) -> Sequence[Feature]:
        """Return the features in a scenario with these robots."""
        return self.features_of(agents)


OBSERVATIONS: Registry[RowObservation | Observation | type[Observation]] = Registry("observation")
"""Registry of additional observations by name."""

OBSERVATIONS.register("time_left", "Share of the episode that is left, the same for all robots.")(
    RowObservation(TIME_LEFT, lambda agents: [Feature("time_left", "of the episode", 0.0, 1.0)])
)
OBSERVATIONS.register("robot_id", "The robot's number as a share: 0 is the first, 1 the last.")(
    RowObservation(ROBOT_ID, lambda agents: [Feature("robot_id", "of all robots", 0.0, 1.0)])
)
OBSERVATIONS.register("one_hot", "One number for each robot; that of the robot itself is 1.")(
    RowObservation(
        ONE_HOT, lambda agents: [Feature(f"is.{each}", "0 or 1", 0.0, 1.0) for each in agents]
    )
)


def previous_action(layout: Layout) -> RowObservation:
    """Return the addition of the last layer inputs, which have this layout."""
    features = [
        Feature(f"previous.{each.name}", each.unit, min(each.low, 0.0), each.high)
        for each in layout
    ]
    return RowObservation(PREVIOUS_ACTION, lambda agents: features)
