"""The registry of weighting rules; what a rule consists of is in `swarm_forage_env.interface`."""

from typing import Protocol, runtime_checkable

from swarm_forage_env.compiler import kernel
from swarm_forage_env.interface import WeightingLayer
from swarm_forage_env.parameters import BaseScenario, Parameters
from swarm_forage_env.registry import Registry

WEIGHTING_RULES: Registry[type[Parameters]] = Registry("weighting rule")
"""Parameters by name. A compiled rule is a `CompiledWeighting`; a rule in NumPy is called with the
records `Exchange`, a row for each robot."""


@runtime_checkable
class CompiledWeighting(Protocol):
    """Parameters of a compiled rule."""

    def layer(self, scenario: BaseScenario) -> WeightingLayer | None:
        """The function of the rule, with its numbers; None for the estimator's own rule."""
        ...


@kernel
def no_gain(*seen: object) -> float:
    """The weight 0: that of a rule written in NumPy comes as an action."""
    return 0.0
