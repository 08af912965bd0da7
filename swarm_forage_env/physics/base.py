"""Engines: what moves the robots of the foraging world."""

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any, Protocol

from swarm_forage_env.arrays import Array
from swarm_forage_env.epuck.scenario import EpuckScenario
from swarm_forage_env.interface import Kernel
from swarm_forage_env.registry import Registry


class Physics(Protocol):
    """Moves the robots of a block of worlds for one tick, before they are scored and sense.

    An engine is a `PythonPhysics` if it has a method `move`, and else a `CompiledPhysics`. If it
    leaves `has_moved` of a world alone, the tick drives every robot as its wheels turn. Robots may
    end up overlapping by a few millimetres: the tick resolves contacts afterwards.
    """

    def reset(self, world: int, scenario: EpuckScenario) -> None:
        """Forget what the engine remembers of one world's past; go by this scenario from now on."""
        ...

    def snapshot(self) -> Any:  # noqa: ANN401 of the engine
        """All that it remembers of the past, picklable."""
        ...

    def restore(self, kept: Any, scenarios: Sequence[EpuckScenario]) -> None:  # noqa: ANN401 as above
        """Go on as when that snapshot was taken, under these scenarios."""
        ...


class PythonPhysics(Physics, Protocol):
    """An engine in Python: ticks of its worlds run one by one, as it comes in between."""

    def move(
        self, robots: Array, worlds: Array, near: Array, obstacles: Array, first: int, last: int
    ) -> None:
        """Move the robots of the worlds first .. last - 1 by one tick.

        `near` holds the neighbours before the move, `obstacles` the capsules of each world.
        """
        ...


class CompiledPhysics(Physics, Protocol):
    """A compiled engine: it runs in the call that runs several ticks."""

    @property
    def move_world(self) -> Kernel:
        """Moves the robots of a world; of the world's arrays, which world, and how many robots."""
        ...

    @property
    def arrays(self) -> tuple[Array, ...]:
        """Arrays of its own, which follow those of the world."""
        ...


@cache
def moves_in_python(engine: type) -> bool:
    """Whether engines of a class are in Python: whether they have a method `move`."""
    return hasattr(engine, "move")


Engine = Callable[[Sequence[EpuckScenario]], PythonPhysics | CompiledPhysics]

ENGINES: Registry[Engine] = Registry("physics engine")
"""Engines by name; each is made from the scenario of every world of a block."""
