"""Observations: the inputs of the learned layer, named additions, and user-defined ones.

A user-defined observation is a class that names its features and writes them, in SI units, from the
records of a block of worlds:

    class Heading:
        def features(self, scenario, agents):
            return [Feature("heading", "rad", -math.pi, math.pi)]

        def write(self, context, out):
            out[:, :, 0] = context.robots["pose"][:, :, 2]

`parallel_env("es1", observation=["layer", Heading])` appends it to the inputs of the layer.
"""

from collections.abc import Sequence
from dataclasses import replace

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
"""Name of the observation that holds the inputs of the learned layer."""

PREVIOUS = "previous_action"

Addition = Observation | RowObservation
"""Addition to the inputs of the layer: a named or a user-defined one."""


def added(observation: object, policy: PolicyInterface) -> tuple[bool, list[Addition]]:
    """Return whether the layer's inputs are observed, and the additions; ConfigError if invalid."""
    wanted = list(observation) if isinstance(observation, list | tuple) else [observation]
    if not wanted:
        raise ConfigError(
            "observation=[]: must name at least one; leave it out for the layer's own"
        )
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
            named = OBSERVATIONS[each]
            additions.append(named if isinstance(named, RowObservation) else _own(named))
    return LAYER in [each for each in wanted if isinstance(each, str)], additions


def _own(observation: object) -> Observation:
    made = observation() if isinstance(observation, type) else observation
    if not isinstance(made, Observation):
        raise ConfigError(
            f"observation={observation!r}: must be '{LAYER}', '{PREVIOUS}', one of"
            f" {', '.join(OBSERVATIONS)}, or a class with `features` and `write`"
        )
    return made


def normalised(layout: Layout) -> Layout:
    """Return the layout of the same features, normalised to [-1, 1]."""
    return Layout(
        Feature(each.name, _unit_of(each), -1.0 if each.low < 0.0 else 0.0, 1.0, each.noise)
        for each in layout
    )


def _unit_of(feature: Feature) -> str:
    if feature.scale is not None:
        return f"x / (|x| + {feature.scale:g}), x in {feature.unit or '1'}"
    return feature.unit if feature.bound == 1.0 else f"of {feature.bound:.4g} {feature.unit}"


def typical_sizes(layout: Layout) -> tuple[Float32[Array, " numbers"], Bool[Array, " numbers"]]:
    """Return the typical size of each feature, and whether it is squashed into [-1, 1].

    x / (|x| + s)       with the typical size s
    x / b               with bounds of +- b as the typical size
    """
    for each in layout:
        if each.scale is None and not 0.0 < each.bound < np.inf:
            raise ConfigError(
                f"observation {each.name}: bounds of {each.low:g} to {each.high:g} give no"
                " typical size; give the feature a scale, or use normalise=False"
            )
    is_squashed = np.array([each.scale is not None for each in layout])
    return np.array([each.size for each in layout], np.float32), is_squashed


def resized(layout: Layout, sizes: Sequence[float]) -> Layout:
    """Return the layout of the same features with other typical sizes."""
    return Layout(
        replace(each, low=-size if each.low < 0.0 else 0.0, high=size)
        if each.scale is None
        else replace(each, scale=size)
        for each, size in zip(layout, sizes, strict=True)
    )


@entry_point
def normalise_rows(
    rows: Float32[Array, "rows numbers"], bound: Float32[Array, " numbers"], squashes: Array
) -> None:
    """Normalise every row in place."""
    for i in range(rows.shape[0]):
        normalise_row(rows[i], bound, squashes)


def stacked(layout: Layout, n: int) -> Layout:
    """Return the layout of n stacked observations, the oldest first."""
    if n == 1:
        return layout
    ages = [f"{n - 1 - k} ago." if k < n - 1 else "" for k in range(n)]
    return Layout(
        Feature(age + each.name, each.unit, each.low, each.high, each.noise)
        for age in ages
        for each in layout
    )


def checked_features(part: Addition, scenario: BaseScenario, agents: Sequence[str]) -> Layout:
    """Return the features of an addition; ConfigError if they are no list of Feature."""
    items: object = part.features(scenario, agents)
    if not isinstance(items, Sequence) or not all(isinstance(each, Feature) for each in items):
        raise ConfigError(
            f"observation {type(part).__name__}: features gave {items!r}, must be a list of Feature"
        )
    return Layout(items)
