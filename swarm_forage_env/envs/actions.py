"""Actions as the policies give them, checked before anything moves."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.compiler import entry_point
from swarm_forage_env.errors import ConfigError, UnknownNameError
from swarm_forage_env.spaces import Layout


class Actions:
    """Turns a dictionary of actions into a matrix, or says what is wrong with it."""

    def __init__(self, agents: Sequence[str], layout: Layout) -> None:
        """Actions of this layout, one for each of these agents."""
        self._agents = tuple(agents)
        self._layout = layout
        box = layout.box()
        self._low, self._high = box.low, box.high
        self._shape = (len(agents), len(layout))

    def matrix(self, actions: Mapping[str, Any]) -> Float32[Array, "rows numbers"]:
        """A row for each agent. ConfigError or UnknownNameError for what cannot be used."""
        try:
            given = np.array([actions[agent] for agent in self._agents])
            usable = self._usable(given) if len(actions) == len(self._agents) else None
        except (IndexError, KeyError, TypeError, ValueError):
            usable = None  # why, is found out below
        if usable is None:
            raise self._complaint(actions)
        return usable

    def rows(self, given: Array) -> Float32[Array, "rows numbers"]:
        """The same from an array that has a row for each agent already."""
        usable = self._usable(given)
        if usable is None:
            raise self._complaint(dict(zip(self._agents, given, strict=True)))
        return usable

    def _usable(self, given: Array) -> Float32[Array, "rows numbers"] | None:
        """The numbers as float32, or None if they are not what the layout says."""
        if given.dtype != np.float32 and given.dtype.kind in "fiu":
            given = given.astype(np.float64)
        if (
            given.shape == self._shape
            and given.dtype.kind == "f"
            and is_within(given, self._low, self._high)
        ):
            return given.astype(np.float32, copy=False)
        return None

    def _complaint(self, actions: Any) -> Exception:  # noqa: ANN401 whatever was passed
        """The first thing that is wrong."""
        if not isinstance(actions, Mapping):
            return ConfigError(f"actions={actions!r}: must be a dictionary, agent to action")
        for agent in actions:
            if agent not in self._agents:
                return UnknownNameError("agent", str(agent), self._agents)
        for agent in self._agents:
            if agent not in actions:
                return ConfigError(f"actions: {agent} has none; every agent needs one")
            complaint = self._complaint_about(agent, actions[agent])
            if complaint:
                return ConfigError(f"action of {agent}: {complaint}")
        return ConfigError("actions: must be arrays of one and the same kind of number")

    def _complaint_about(self, agent: str, action: Any) -> str:  # noqa: ANN401
        try:
            given = np.asarray(action, dtype=np.float64)
        except (TypeError, ValueError):
            return f"{action!r}: must be numbers, {', '.join(self._layout.names)}"
        if given.shape != self._shape[1:]:
            return (
                f"shape {given.shape}: must be {self._shape[1:]},"
                f" for {', '.join(self._layout.names)}"
            )
        for feature, value in zip(self._layout, given, strict=True):
            if not feature.low <= value <= feature.high:
                return (
                    f"{feature.name}={value:g}: must be from {feature.low:g} to {feature.high:g}"
                    f" [{feature.unit}]; clip it first, as numpy.clip does"
                )
        return ""


@entry_point
def is_within(
    given: Array, low: Float32[Array, " numbers"], high: Float32[Array, " numbers"]
) -> bool:
    """Every number of every row is within its bounds; NaN is not."""
    for i in range(given.shape[0]):
        for k in range(given.shape[1]):
            if not low[k] <= given[i, k] <= high[k]:
                return False
    return True
