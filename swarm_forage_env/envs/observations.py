"""Observations: what the learned layer is shown, additions to it, and ones of the user's own.

An observation of the user's own is a class that names its features and writes them, in SI units,
from the records of a block of worlds:

    class Heading:
        def features(self, scenario, agents):
            return [Feature("heading", "rad", -math.pi, math.pi)]

        def write(self, context, out):
            out[:, :, 0] = context.robots["pose"][:, :, 2]

`parallel_env("es1", observation=["layer", Heading])` shows it beside what the layer sees.
"""

from collections.abc import Sequence

import numpy as np

from swarm_forage_env.arrays import Array, Bool, Float32
from swarm_forage_env.compiler import entry_point
from swarm_forage_env.envs.decision_kernels import normalise_row
from swarm_forage_env.envs.extra_observations import (
    OBSERVATIONS,
    Observation,
    RowObservation,
    previous_action,
)
from swarm_forage_env.errors import ConfigError, UnknownNameError
from swarm_forage_env.parameters import BaseScenario
from swarm_forage_env.policy_interface import PolicyInterface
from swarm_forage_env.registry import left_out
from swarm_forage_env.spaces import Feature, Layout

LAYER = "layer"
"""The name of what the learned layer is shown."""

PREVIOUS = "previous_action"

Addition = Observation | RowObservation
"""What is observed beside the layer: by name, or a class of the user's own."""


def added(observation: object, policy: PolicyInterface) -> tuple[bool, list[Addition]]:
    """Whether what the layer sees is shown, and what beside it; ConfigError for what is none."""
    wanted = list(observation) if isinstance(observation, list | tuple) else [observation]
    if not wanted:
        raise ConfigError("observation=[]: must name something; leave it out for the layer's own")
    additions: list[Addition] = []
    for each in wanted:
        if not isinstance(each, str):
            additions.append(_own(each))
        elif each == PREVIOUS:
            additions.append(previous_action(policy.action))
        elif each != LAYER and each not in OBSERVATIONS:
            known = LAYER, PREVIOUS, *OBSERVATIONS
            raise UnknownNameError("observation", each, known, left_out())
        elif each != LAYER:
            additions.append(OBSERVATIONS[each])
    return LAYER in [each for each in wanted if isinstance(each, str)], additions


def _own(observation: object) -> Observation:
    made = observation() if isinstance(observation, type) else observation
    if not isinstance(made, Observation):
        raise ConfigError(
            f"observation={observation!r}: must be '{LAYER}', '{PREVIOUS}', a name of"
            f" {', '.join(OBSERVATIONS)}, or a class with `features` and `write`"
        )
    return made


def normalised(layout: Layout) -> Layout:
    """The same features as shares of their typical sizes, within [-1, 1]."""
    return Layout(
        Feature(each.name, _unit_of(each), -1.0 if each.low < 0.0 else 0.0, 1.0, each.noise)
        for each in layout
    )


def _unit_of(feature: Feature) -> str:
    if feature.scale is not None:
        return f"x / (|x| + {feature.scale:g}), x in {feature.unit or '1'}"
    return feature.unit if feature.bound == 1.0 else f"of {feature.bound:.4g} {feature.unit}"


def typical_sizes(layout: Layout) -> tuple[Float32[Array, " numbers"], Bool[Array, " numbers"]]:
    """The typical size of each number, and which of them are squashed into [-1, 1].

    x / (|x| + s)       of typical size s
    x / b               within bounds of +- b that are typical themselves
    """
    for each in layout:
        if each.scale is None and not 0.0 < each.bound < np.inf:
            raise ConfigError(
                f"observation {each.name}: bounds of {each.low:g} to {each.high:g} tell no"
                " typical size; give the feature a scale, or take normalise=False"
            )
    sizes = [each.bound if each.scale is None else each.scale for each in layout]
    return np.array(sizes, np.float32), np.array([each.scale is not None for each in layout])


@entry_point
def normalise_rows(
    rows: Float32[Array, "rows numbers"], bound: Float32[Array, " numbers"], squashes: Array
) -> None:
    """Normalise every row."""
    for i in range(rows.shape[0]):
        normalise_row(rows[i], bound, squashes)


def stacked(layout: Layout, n: int) -> Layout:
    """The layout of the last n observations, the oldest first."""
    if n == 1:
        return layout
    ages = [f"{n - 1 - k} ago." if k < n - 1 else "" for k in range(n)]
    return Layout(
        Feature(age + each.name, each.unit, each.low, each.high, each.noise)
        for age in ages
        for each in layout
    )


def checked_features(part: Addition, scenario: BaseScenario, agents: Sequence[str]) -> Layout:
    """What an addition says its numbers are; ConfigError for what are no features."""
    items: object = part.features(scenario, agents)
    if not isinstance(items, Sequence) or not all(isinstance(each, Feature) for each in items):
        raise ConfigError(
            f"observation {type(part).__name__}: features gave {items!r}, must be a list of Feature"
        )
    return Layout(items)
