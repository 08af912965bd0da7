"""Observations: what the learned layer is shown, additions to it, and ones of the user's own.

An observation of the user's own is a class that names its features and writes them, in SI units,
from the records of a block of worlds:

    class Heading:
        def features(self, scenario, agents):
            return [Feature("heading", "rad", -math.pi, math.pi)]

        def write(self, moment, out):
            out[:, :, 0] = moment.robots["pose"][:, :, 2]

`parallel_env("es1", observation=["layer", Heading])` shows it beside what the layer sees.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from swarm_forage_env.arrays import Array, Float32, Float64
from swarm_forage_env.compiler import entry_point, inlined
from swarm_forage_env.envs.added_observations import (
    OBSERVATIONS,
    Moment,
    Observation,
    PreviousAction,
)
from swarm_forage_env.equations.elementary import hypot
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.no_layers import has_estimators
from swarm_forage_env.observed_fields import FieldCopies, FieldLayout
from swarm_forage_env.policy_interface import PolicyInterface
from swarm_forage_env.spaces import Feature, Layout

LAYER = "layer"
"""The name of what the learned layer is shown."""


PREVIOUS = "previous_action"


def added(observation: Any, policy: PolicyInterface) -> tuple[bool, list[Observation]]:  # noqa: ANN401 names and classes
    """Whether what the layer sees is shown, and what is shown beside it.

    ConfigError or UnknownNameError for what is no observation.
    """
    given = list(observation) if isinstance(observation, list | tuple) else [observation]
    if not given:
        raise ConfigError("observation=[]: must name something; leave it out for the layer's own")
    found: list[Observation] = []
    for each in given:
        if each == PREVIOUS:
            found.append(PreviousAction(policy.action))
        elif isinstance(each, str) and each != LAYER:
            found.append(OBSERVATIONS[each]())
        elif each != LAYER:
            found.append(_own(each))
    return LAYER in [each for each in given if isinstance(each, str)], found


def _own(given: Any) -> Observation:  # noqa: ANN401 whatever was passed
    """An observation of the user's own, made if it is a class; ConfigError for anything else."""
    made = given() if isinstance(given, type) else given
    if not (hasattr(made, "features") and hasattr(made, "write")):
        raise ConfigError(
            f"observation={given!r}: must be '{LAYER}', '{PREVIOUS}', a name of"
            f" {', '.join(OBSERVATIONS)}, or a class with `features` and `write`"
        )
    found: Observation = made
    return found


def normalised(layout: Layout) -> Layout:
    """The same features as shares of their typical sizes, within [-1, 1]."""
    return Layout(
        Feature(
            each.name,
            _unit_of(each),
            -1.0 if each.low < 0.0 else 0.0,
            1.0,
            each.noise,
        )
        for each in layout
    )


def _unit_of(feature: Feature) -> str:
    """What a normalised number is."""
    if feature.scale is not None:
        return f"x / (|x| + {feature.scale:g}), x in {feature.unit or '1'}"
    return feature.unit if feature.bound == 1.0 else f"of {feature.bound:.4g} {feature.unit}"


class Normaliser:
    """Brings numbers in SI units into [-1, 1].

    x / (|x| + s)       of typical size s
    x / b               within bounds of +- b that are typical themselves
    """

    def __init__(self, layout: Layout) -> None:
        """Numbers of this layout; ConfigError for one of no typical size."""
        for each in layout:
            if each.scale is None and not 0.0 < each.bound < np.inf:
                raise ConfigError(
                    f"observation {each.name}: bounds of {each.low:g} to {each.high:g} tell no"
                    " typical size; give the feature a scale, or take normalise=False"
                )
        self.bound = np.array(
            [each.bound if each.scale is None else each.scale for each in layout], np.float32
        )
        self.squashes = np.array([each.scale is not None for each in layout])

    def __call__(self, numbers: Float32[Array, "*any numbers"]) -> None:
        """In place."""
        normalise_rows(numbers.reshape(-1, len(self.bound)), self.bound, self.squashes)


@inlined
def normalise_row(
    row: Float32[Array, " numbers"], bound: Float32[Array, " numbers"], squashes: Array
) -> None:
    """Divide by the bound, or squash by the scale, in place."""
    for k in range(row.shape[0]):
        if squashes[k]:
            row[k] = row[k] / (abs(row[k]) + bound[k])
        else:
            row[k] = row[k] / bound[k]


@inlined
def write_direction(row: Float32[Array, " numbers"], at: int, to: int) -> None:
    """Write the unit vector of the two numbers from `at` on; zeros for no direction."""
    x, y = row[at], row[at + 1]
    size = hypot(x, y)
    row[to] = x / size if size > 0.0 else 0.0
    row[to + 1] = y / size if size > 0.0 else 0.0


@entry_point
def normalise_rows(
    rows: Float32[Array, "rows numbers"], bound: Float32[Array, " numbers"], squashes: Array
) -> None:
    """Normalise every row."""
    for i in range(rows.shape[0]):
        normalise_row(rows[i], bound, squashes)


@entry_point
def write_directions(out: Float32[Array, "worlds robots numbers"], at: int, to: int) -> None:
    """Write the direction of every robot."""
    for w in range(out.shape[0]):
        for i in range(out.shape[1]):
            write_direction(out[w, i], at, to)


class Observer:
    """Writes what every robot of a block of worlds observes, a fresh array each time."""

    layout: Layout
    """What each number is."""

    parts: list[Observation]
    """What is observed beside the layer."""

    spans: list[tuple[int, int]]
    """Where the numbers of each of these stand: first and last + 1."""

    shown: FieldLayout
    """What the layer sees."""

    n_shown: int
    """How many numbers of it are observed: all, or none."""

    def __init__(
        self,
        policy: PolicyInterface,
        observation: Any,  # noqa: ANN401 names and classes
        shown: FieldLayout,
        scenario: Any,  # noqa: ANN401 of any task
        agents: Sequence[str],
        normalise: bool,
    ) -> None:
        """What the layer is `shown`, if it is, and what is asked for beside it."""
        has_layer, self.parts = added(observation, policy)
        layout: Layout = shown if has_layer else Layout(())
        self.n_shown = len(layout)
        self.shown, self._copies = shown, FieldCopies(shown)
        self._direction = -1
        if normalise and has_layer and policy.target is not None:
            self._direction = _first_of(policy.target, layout)
            layout = Layout((*layout, *_directions(policy.target)))
        self.spans = []
        for part in self.parts:
            features = part.features(scenario, agents)
            self.spans.append((len(layout), len(layout) + len(features)))
            layout = layout if not features else Layout((*layout, *features))
        _check_names(layout)
        self._normalise = Normaliser(layout) if normalise else None
        self.layout = normalised(layout) if normalise else layout
        self._n = len(layout)

    @property
    def on_grid(self) -> tuple[Array, Array, Array]:
        """Where the target starts and where its direction goes; bounds; which of them squash."""
        direction = np.array([self._direction, self.n_shown], np.int64)
        if self._normalise is None:
            return direction, np.zeros(0, np.float32), np.zeros(0, np.bool_)
        return direction, self._normalise.bound, self._normalise.squashes

    def __call__(
        self,
        world: Any,  # noqa: ANN401 of its task
        controller: Any,  # noqa: ANN401 as above
        time_left: Callable[[], Float64[Array, " worlds"]],
        last_action: Float32[Array, "worlds robots numbers"],
    ) -> Float32[Array, "worlds robots numbers"]:
        """What every robot observes.

        The share of the episode that is left is asked for, and the actions before are read, by
        what is observed beside the layer.
        """
        shape = (world.n_worlds, world.n_robots, self._n)
        out = np.empty(shape, np.float32)
        if self.n_shown:
            self._copies.read(world, controller.minds, out)
        if self._direction >= 0:
            write_directions(out, self._direction, self.n_shown)
        if self.parts:
            self._add(_moment(world, controller, time_left(), last_action), out)
        if self._normalise is not None:
            self._normalise(out)
        return out

    def _add(self, moment: Moment, out: Float32[Array, "worlds robots numbers"]) -> None:
        """Write what is observed beside the layer; ConfigError for what is not finite."""
        for part, (first, last) in zip(self.parts, self.spans, strict=True):
            part.write(moment, out[:, :, first:last])
            _check_finite(out[:, :, first:last], self.layout[first:last])


def _moment(
    world: Any,  # noqa: ANN401 of its task
    controller: Any,  # noqa: ANN401 as above
    time_left: Float64[Array, " worlds"],
    last_action: Float32[Array, "worlds robots numbers"],
) -> Moment:
    """The records as they stand."""
    minds = controller.minds
    estimator = minds["estimator"] if has_estimators(minds) else None
    return Moment(world.robots, world.worlds, estimator, time_left, last_action)


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


def _first_of(target: str, layout: Layout) -> int:
    """Where the observed vector of this name starts."""
    return layout.names.index(f"{target}.x")


def _directions(target: str) -> list[Feature]:
    return [Feature(f"{target}.direction.{axis}", "ratio", -1.0, 1.0) for axis in "xy"]


def _check_names(layout: Layout) -> None:
    """ConfigError if there is nothing to observe, or two numbers have one name."""
    names = layout.names
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice or not names:
        raise ConfigError(f"observation: must have features of different names; twice: {twice}")


def _check_finite(numbers: Array, features: Sequence[Feature]) -> None:
    """ConfigError for NaN or infinity, which an observation of the user's own has written."""
    if not np.isfinite(numbers).all():
        k = int(np.argwhere(~np.isfinite(numbers))[0, 2])
        raise ConfigError(f"observation {features[k].name}: is not finite; write a number")
