"""Registry of weighting rules; `swarm_forage_env.interface` defines their interface."""

from swarm_forage_env.compiler import kernel
from swarm_forage_env.parameters import Parameters
from swarm_forage_env.registry import Registry

WEIGHTING_RULES: Registry[type[Parameters]] = Registry("weighting rule")
"""Classes of parameters by name. The method `layer(scenario)` of a compiled rule returns a
`WeightingLayer`, or None for the rule of the estimator; a rule in NumPy is called with records
`Exchange`, one row per robot."""


@kernel
def no_gain(*seen: object) -> float:
    """Return the weight 0: a rule written in NumPy writes its weight as an action instead."""
    return 0.0
