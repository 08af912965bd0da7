"""The registry of motion rules; what one consists of is in `swarm_forage_env.interface`."""

from swarm_forage_env.parameters import Parameters
from swarm_forage_env.registry import Registry

MOTIONS: Registry[type[Parameters]] = Registry("motion")
"""Parameters by name. The method `layer(scenario)` of a compiled motion returns a `MotionLayer`, or
None where it is a rule in NumPy; the method `start(scenario, seeds)` of that, a `MotionRule`."""
