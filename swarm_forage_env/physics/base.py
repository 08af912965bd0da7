"""Engines: what moves the robots of the foraging world."""

from collections.abc import Callable, Sequence
from typing import Any, Protocol

from swarm_forage_env.arrays import Array
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.registry import Registry


class Physics(Protocol):
    """Moves the robots of a block of worlds for one tick, before the kernel `tick`.

    An engine that leaves `has_moved` of a world alone leaves the motion to that kernel, which
    drives every robot as its wheels turn. Robots may end up overlapping by a few millimetres:
    the kernel resolves contacts after it.
    """

    def move(
        self, robots: Array, worlds: Array, near: Array, obstacles: Array, first: int, last: int
    ) -> None:
        """Move the robots of the worlds first .. last - 1 by one tick.

        `near` holds the neighbours before the move, `obstacles` the capsules of each world.
        """
        ...

    def reset(self, world: int, scenario: Scenario) -> None:
        """Forget what the engine remembers of one world's past; go by this scenario from now on."""
        ...

    def snapshot(self) -> Any:  # noqa: ANN401 of the engine
        """All that it remembers of the past, picklable."""
        ...

    def restore(self, kept: Any, scenarios: Sequence[Scenario]) -> None:  # noqa: ANN401 as above
        """Go on as when that snapshot was taken, under these scenarios."""
        ...


ENGINES: Registry[Callable[[Sequence[Scenario]], Physics]] = Registry("physics engine")
"""Engines by name; each is made from the scenario of every world of a block."""
