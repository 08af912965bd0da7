"""What the world asks of an engine."""

from collections.abc import Callable
from typing import Protocol

from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.neighbours import Neighbours
from swarm_forage_env.registry import Registry
from swarm_forage_env.scenario import Scenario


class Physics(Protocol):
    """Moves all robots of a block of worlds for one tick; the arrays are the truth.

    Robots may end up overlapping by a few millimetres: the world settles contacts after it.
    """

    def move(
        self,
        pose: Float64[Array, "rows 3"],
        wheels: Float64[Array, "rows 2"],
        neighbours: Neighbours,
    ) -> None:
        """Advance the poses (world frame) by one tick of these wheel speeds [m/s], in place.

        `neighbours` holds the pairs that are close before the move.
        """
        ...

    def reset(self, world: int) -> None:
        """Forget what the engine remembers of one world's past."""
        ...


ENGINES: Registry[Callable[[Scenario, int], Physics]] = Registry("physics engine")
"""Engines by name; each is made from a scenario and the number of worlds."""
