"""The engine `kinematic`: wheels integrated exactly, no forces.

In a contact robots keep turning their wheels and are moved apart along the line between their
centres; they do not push, slide or turn each other.
"""

from collections.abc import Sequence

from swarm_forage_env.arrays import Array
from swarm_forage_env.epuck.scenario import EpuckScenario
from swarm_forage_env.interface import Kernel
from swarm_forage_env.physics.base import ENGINES
from swarm_forage_env.ticks import nothing


@ENGINES.register("kinematic")
class Kinematic:
    """Robots go where their wheels take them, without forces; where two overlap, they part."""

    def __init__(self, scenarios: Sequence[EpuckScenario]) -> None:
        """Nothing is kept."""

    @property
    def move_world(self) -> Kernel:
        """Leaves the motion to the tick."""
        return nothing

    @property
    def arrays(self) -> tuple[Array, ...]:
        """There are none."""
        return ()

    def reset(self, world: int, scenario: EpuckScenario) -> None:
        """There is nothing to forget."""

    def snapshot(self) -> None:
        """There is nothing to remember."""

    def restore(self, kept: None, scenarios: Sequence[EpuckScenario]) -> None:
        """There is nothing to remember."""
