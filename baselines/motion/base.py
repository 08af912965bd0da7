"""Registry of motions; `swarm_forage_env.interface` defines their interface."""

from swarm_forage_env.parameters import Parameters
from swarm_forage_env.registry import Registry

MOTIONS: Registry[type[Parameters]] = Registry("motion")
"""Classes of parameters by name. The method `layer(scenario)` of a compiled motion returns a
`MotionLayer`; for a rule in NumPy, the method `start(scenario, seeds)` returns a `MotionRule`."""
