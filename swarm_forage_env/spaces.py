"""Spaces: what each number of a flat observation, action or state means."""

import html
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from gymnasium.spaces import Box

from swarm_forage_env.arrays import Array, Float32, Int8
from swarm_forage_env.errors import ConfigError

GOALS = ("nest", "prey", "none")
"""The three slots of a goal, one of which is 1: so an observation is never all zeros."""

_ONE_OF_GOALS: Float32[Array, "goals 3"] = np.eye(3, dtype=np.float32)
_GOAL_OF_SLOT = np.array([0, 1, -1], np.int8)


HEADS = ("", "name", "unit", "low", "high", "noise")
"""What a table of slots says of each."""


@dataclass(frozen=True, slots=True)
class Feature:
    """One number of a flat Box."""

    name: str
    """Dotted: part, field, which number of it: `situation.beam.0.range`."""

    unit: str
    """SI, or what the number is."""

    low: float
    high: float
    """Bounds; infinite for a number of no natural limits, which has a scale."""

    noise: str = ""
    """How it differs from the truth, for what is measured."""

    scale: float | None = None
    """Typical size in that unit; None: the bounds are typical."""

    @property
    def bound(self) -> float:
        """The largest size."""
        return max(abs(self.low), abs(self.high))


@dataclass(frozen=True, slots=True)
class FeatureGroup:
    """One array of the interface as consecutive slots, row by row."""

    name: str
    shape: tuple[int, ...]
    """Axes after the rows."""

    dtype: type[np.generic]
    slots: tuple[Feature, ...]

    @property
    def is_goal(self) -> bool:
        """A choice of a goal, which takes one slot for each."""
        return self.name == "goal" and not self.shape


def feature_group(  # noqa: PLR0913 one line of a table
    name: str,
    ends: Iterable[str],
    unit: str,
    bounds: tuple[float, float],
    noise: str = "",
    shape: tuple[int, ...] | None = None,
    dtype: type[np.generic] = np.float32,
    scale: float | None = None,
) -> FeatureGroup:
    """A field with one slot for each end of its name; the shape is flat unless given."""
    low, high = bounds
    names = [f"{name}.{end}" if end else name for end in ends]
    slots = tuple(Feature(each, unit, low, high, noise, scale) for each in names)
    return FeatureGroup(name, (len(slots),) if shape is None else shape, dtype, slots)


class Layout(tuple[Feature, ...]):
    """The slots of a flat Box, in order. `print` shows them as a table."""

    __slots__ = ()

    @property
    def names(self) -> tuple[str, ...]:
        """The name of every slot."""
        return tuple(slot.name for slot in self)

    def box(self) -> Box:
        """The space: float32, infinite where a feature has no natural bounds."""
        low = np.array([slot.low for slot in self], np.float32)
        high = np.array([slot.high for slot in self], np.float32)
        return Box(low, high, dtype=np.float32)

    def __str__(self) -> str:
        """One line for each slot: number, name, unit, bounds and noise."""
        lines = [HEADS, *self._lines()]
        widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
        padded = ([c.ljust(w) for c, w in zip(line, widths, strict=True)] for line in lines)
        return "\n".join("  ".join(line).rstrip() for line in padded)

    def _repr_html_(self) -> str:
        """The same as a table, for notebooks."""
        rows = ["".join(f"<th>{name}</th>" for name in HEADS)]
        rows += ["".join(f"<td>{html.escape(t)}</td>" for t in line) for line in self._lines()]
        table = "".join(f"<tr>{row}</tr>" for row in rows)
        return f'<div style="max-height:20em;overflow:auto"><table>{table}</table></div>'

    def _lines(self) -> Iterator[tuple[str, ...]]:
        """The texts of each slot, as HEADS names them."""
        for k, slot in enumerate(self):
            low, high = f"{slot.low:.6g}", f"{slot.high:.6g}"
            yield str(k), slot.name, slot.unit, low, high, slot.noise


class ObservationLayout(Layout):
    """The layout of an observation, which can be turned back into what the layers see."""

    parts: Mapping[str, tuple[FeatureGroup, ...]]
    """The features of each part of the interface that the observation holds."""

    inputs: Mapping[str, type[Any]]
    """What each part is as arrays: a dataclass whose fields are the part's features."""

    def __new__(
        cls,
        parts: Mapping[str, tuple[FeatureGroup, ...]],
        inputs: Mapping[str, type[Any]] | None = None,
    ) -> "ObservationLayout":
        """The features of all parts, each name starting with its part's."""
        features = (
            replace(feature, name=f"{part}.{feature.name}")
            for part, each in _groups(parts)
            for feature in each.slots
        )
        layout = super().__new__(cls, features)
        layout.parts, layout.inputs = dict(parts), dict(inputs or {})
        return layout

    def __getnewargs__(self) -> tuple[Any, Any]:
        """What makes the same layout again in another process."""
        return self.parts, self.inputs

    def encounter(self, observations: Float32[Array, "rows numbers"]) -> Any:  # noqa: ANN401 of its task
        """What the weighting layer sees, from the observations of all robots stacked."""
        return self._part("encounter", observations)

    def situation(self, observations: Float32[Array, "rows numbers"]) -> Any:  # noqa: ANN401 of its task
        """What the motion layer sees, from the observations of all robots stacked."""
        return self._part("situation", observations)

    def views(
        self, part: str, matrix: Float32[Array, "rows numbers"]
    ) -> Iterator[tuple[FeatureGroup, Array]]:
        """Each group of a part, and its columns in the matrix in the group's own shape."""
        start = 0
        for owner, each in _groups(self.parts):
            stop = start + len(each.slots)
            if owner == part:
                shape = (len(GOALS),) if each.is_goal else each.shape
                yield each, matrix[:, start:stop].reshape(len(matrix), *shape)
            start = stop

    def _part(self, name: str, observations: Array) -> Any:  # noqa: ANN401 of its task
        if name not in self.parts or name not in self.inputs:
            held = ", ".join(self.parts)
            raise ConfigError(f"this observation holds no {name}, only {held}")
        matrix = np.asarray(observations, np.float32)
        if matrix.ndim != 2 or matrix.shape[1] != len(self):
            raise ConfigError(
                f"observations of shape {matrix.shape}: must be (robots, {len(self)}), as"
                " numpy.stack(list(observations.values())) gives"
            )
        found = {}
        for each, view in self.views(name, matrix):
            if each.is_goal:
                found[each.name] = _GOAL_OF_SLOT[view.argmax(axis=1)]
            else:
                found[each.name] = view.astype(each.dtype, order="C")
        return self.inputs[name](**found)


def widest(layouts: Sequence[Layout]) -> Layout:
    """A layout whose bounds hold for all of these, which differ in nothing else.

    Only that some may leave out features of the longest.
    """
    first = max(layouts, key=len)
    lows: dict[str, float] = {}
    highs: dict[str, float] = {}
    for feature in (each for layout in layouts for each in layout):
        lows[feature.name] = min(feature.low, lows.get(feature.name, feature.low))
        highs[feature.name] = max(feature.high, highs.get(feature.name, feature.high))
    wide = [replace(each, low=lows[each.name], high=highs[each.name]) for each in first]
    if not isinstance(first, ObservationLayout):
        return Layout(wide)
    parts: dict[str, list[FeatureGroup]] = {part: [] for part in first.parts}
    for part, group in _groups(first.parts):
        own, wide = wide[: len(group.slots)], wide[len(group.slots) :]
        slots = (replace(each, name=each.name.removeprefix(f"{part}.")) for each in own)
        parts[part].append(replace(group, slots=tuple(slots)))
    return ObservationLayout({part: tuple(groups) for part, groups in parts.items()}, first.inputs)


class ObservationWriter:
    """A matrix that the parts of the interface are written to, a row for each robot."""

    def __init__(self, layout: ObservationLayout, rows: int) -> None:
        """The matrix of a layout for so many robots."""
        self._layout = layout
        self._matrix = np.zeros((rows, len(layout)), np.float32)
        self._views = {
            part: [
                (each.name, each.is_goal, view) for each, view in layout.views(part, self._matrix)
            ]
            for part in layout.parts
        }

    def __reduce__(self) -> tuple[Any, ...]:
        """A copy has a matrix of its own, and its parts are parts of that."""
        return type(self), (self._layout, len(self._matrix))

    def write(self, parts: Mapping[str, Any]) -> Float32[Array, "rows numbers"]:
        """A fresh matrix of observations."""
        for part, views in self._views.items():
            source = parts[part]
            for name, is_goal, view in views:
                value = getattr(source, name)
                view[...] = goal_slots(value) if is_goal else value
        return self._matrix.copy()


def goal_slots(goal: Int8[Array, " rows"]) -> Float32[Array, "rows goals"]:
    """A goal (0 nest, 1 prey, -1 none) as three slots, one of which is 1."""
    return _ONE_OF_GOALS.take(goal, axis=0, mode="wrap")  # -1 is the last, none


def _groups(
    parts: Mapping[str, tuple[FeatureGroup, ...]],
) -> Iterator[tuple[str, FeatureGroup]]:
    for part, groups in parts.items():
        for each in groups:
            yield part, each
