"""Interface and registry of the physics engines."""

from collections.abc import Callable, Sequence
from typing import Any

from swarm_forage_env.arrays import Array
from swarm_forage_env.epuck.scenario import EpuckScenario
from swarm_forage_env.interface import Kernel
from swarm_forage_env.registry import Registry
from swarm_forage_env.ticks import nothing


class Physics:
    """Engine that moves the robots of a block of worlds in each tick, before scoring and sensing.

    This base class moves no robots: the tick integrates the wheels in every world whose `has_moved`
    the engine has not set. An engine written in Python has a method `move(robots, worlds, near,
    obstacles, first, last)`, which moves the robots of worlds first .. last - 1 by one tick: `near`
    holds the neighbours before the tick, `obstacles` the capsules of each world. Robots may then
    overlap by a few millimetres: the tick resolves contacts afterwards.
    """

    arrays: tuple[Array, ...] = ()
    """Arrays of the engine, appended to those of the world."""

    def __init__(self, scenarios: Sequence[EpuckScenario]) -> None:
        """Create the engine for one world per scenario."""

    @property
    def move_world(self) -> Kernel:
        """Kernel that moves the robots of a world: (world arrays, index of the world, n_robots)."""
        return nothing

    def reset(self, world: int, scenario: EpuckScenario) -> None:
        """Clear the memory of one world and set its scenario."""

    def snapshot(self) -> object:
        """Return the memory of the engine as a picklable object."""

    def restore(self, snapshot: Any, scenarios: Sequence[EpuckScenario]) -> None:  # noqa: ANN401 as above
        """Restore a snapshot, with these scenarios."""


ENGINES: Registry[Callable[[Sequence[EpuckScenario]], Physics]] = Registry("physics engine")
"""Engines by name; each takes the scenarios of the worlds of a block."""
