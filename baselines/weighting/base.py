"""The registry of weighting rules; what a rule consists of is in `swarm_forage_env.interface`."""

from typing import Any

from swarm_forage_env.compiler import kernel
from swarm_forage_env.registry import Registry

WEIGHTING_RULES: Registry[Any] = Registry("weighting rule")
"""Rules by name; each is a `Part` whose fields are its parameters. A compiled rule has a method
`layer(scenario)`, which returns a `WeightingLayer`; a rule in NumPy is called with the records
`Exchange`, a row for each robot."""


@kernel
def no_gain(*seen: object) -> float:
    """Nothing is taken over: the weight of a rule written in NumPy comes as an action."""
    return 0.0
