"""The registry of weighting rules; what a rule consists of is in `swarm_forage_env.interface`."""

from swarm_forage_env.compiler import kernel
from swarm_forage_env.parameters import Parameters
from swarm_forage_env.registry import Registry

WEIGHTING_RULES: Registry[type[Parameters]] = Registry("weighting rule")
"""Parameters by name. The method `layer(scenario)` of a compiled rule returns a `WeightingLayer`,
or None for the estimator's own rule; a rule in NumPy is called with the records `Exchange`, a row
for each robot."""


@kernel
def no_gain(*seen: object) -> float:
    """The weight 0: that of a rule written in NumPy comes as an action."""
    return 0.0
