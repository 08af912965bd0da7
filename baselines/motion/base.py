"""The registry of motion rules; what one consists of is in `swarm_forage_env.interface`."""

from typing import Protocol, runtime_checkable

from swarm_forage_env.interface import MotionLayer
from swarm_forage_env.parameters import BaseScenario, Parameters
from swarm_forage_env.registry import Registry

MOTIONS: Registry[type[Parameters]] = Registry("motion")
"""Parameters by name. A compiled motion is a `CompiledMotion`; a motion in NumPy has a method
`start(scenario, seeds)`, which returns a `MotionRule`."""


@runtime_checkable
class CompiledMotion(Protocol):
    """Parameters of a compiled motion."""

    def layer(self, scenario: BaseScenario) -> MotionLayer | None:
        """The functions of the motion, with its numbers; None where it is a rule in NumPy."""
        ...
