"""Engines: what moves the robots of the foraging world."""

from collections.abc import Callable, Sequence
from typing import Any

from swarm_forage_env.arrays import Array
from swarm_forage_env.epuck.scenario import EpuckScenario
from swarm_forage_env.interface import Kernel
from swarm_forage_env.registry import Registry
from swarm_forage_env.ticks import nothing


class Physics:
    """Moves the robots of a block of worlds for one tick, before they are scored and sense.

    This one leaves that to the tick, which drives every robot as its wheels turn where an engine
    leaves `has_moved` of a world alone. An engine with a method `move(robots, worlds, near,
    obstacles, first, last)` is in Python, and moves the robots of the worlds first .. last - 1 by
    one tick: `near` holds the neighbours before it, `obstacles` the capsules of each world. Robots
    may end up overlapping by a few millimetres: the tick resolves contacts afterwards.
    """

    arrays: tuple[Array, ...] = ()
    """Arrays of its own, which follow those of the world."""

    def __init__(self, scenarios: Sequence[EpuckScenario]) -> None:
        """Of worlds of these scenarios."""

    @property
    def move_world(self) -> Kernel:
        """Moves the robots of a world; of the world's arrays, which world, and how many robots."""
        return nothing

    def reset(self, world: int, scenario: EpuckScenario) -> None:
        """Forget one world's past; its scenario is this one from now on."""

    def snapshot(self) -> object:
        """All that it remembers of the past, picklable."""

    def restore(self, kept: Any, scenarios: Sequence[EpuckScenario]) -> None:  # noqa: ANN401 as above
        """Go on as when that snapshot was taken, under these scenarios."""


ENGINES: Registry[Callable[[Sequence[EpuckScenario]], Physics]] = Registry("physics engine")
"""Engines by name; each is made from the scenario of every world of a block."""
