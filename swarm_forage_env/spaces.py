"""Spaces: the meaning of each element of a flat observation, action or state."""

import html
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from gymnasium.spaces import Box

from swarm_forage_env.errors import ConfigError

GOALS = ("nest", "prey", "none")
"""Elements of a one-hot goal, with which an observation is never all zeros."""


HEADS = ("", "name", "unit", "low", "high", "noise")
"""Headings of the table of a layout."""


@dataclass(frozen=True, slots=True)
class Feature:
    """One element of a flat Box."""

    name: str
    """Dotted name of part, field and element: `situation.beam.0.range`."""
    unit: str
    """SI unit, or the meaning of the value."""
    low: float
    high: float
    """Bounds; infinite for a value without natural limits, which has a scale."""
    noise: str = ""
    """Description of the measurement noise; empty for a value without noise."""
    scale: float | None = None
    """Typical magnitude in that unit; None: the bounds are typical."""

    def __post_init__(self) -> None:
        if not self.low <= self.high:
            raise ConfigError(f"feature {self.name}: low={self.low} must be at most {self.high}")
        if self.scale is not None and not 0.0 < self.scale < math.inf:
            raise ConfigError(f"feature {self.name}: scale={self.scale} must be above 0, finite")

    @property
    def bound(self) -> float:
        """Largest absolute value within the bounds."""
        return max(abs(self.low), abs(self.high))

    @property
    def size(self) -> float:
        """Typical size: the scale, or the bound of a feature without one."""
        return float(self.bound if self.scale is None else self.scale)


class Layout(tuple[Feature, ...]):
    """Features of a flat Box, in order; `print` shows them as a table."""

    __slots__ = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the features."""
        return tuple(slot.name for slot in self)

    def box(self) -> Box:
        """Return the space: float32, infinite where a feature has no natural bounds."""
        low = np.array([slot.low for slot in self], np.float32)
        high = np.array([slot.high for slot in self], np.float32)
        return Box(low, high, dtype=np.float32)

    def __str__(self) -> str:
        lines = [HEADS, *self._lines()]
        widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
        padded = ([c.ljust(w) for c, w in zip(line, widths, strict=True)] for line in lines)
        return "\n".join("  ".join(line).rstrip() for line in padded)

    def _repr_html_(self) -> str:
        rows = ["".join(f"<th>{name}</th>" for name in HEADS)]
        rows += ["".join(f"<td>{html.escape(t)}</td>" for t in line) for line in self._lines()]
        table = "".join(f"<tr>{row}</tr>" for row in rows)
        return f'<div style="max-height:20em;overflow:auto"><table>{table}</table></div>'

    def _lines(self) -> Iterator[tuple[str, ...]]:
        for k, slot in enumerate(self):
            low, high = f"{slot.low:.6g}", f"{slot.high:.6g}"
            yield str(k), slot.name, slot.unit, low, high, slot.noise


def widest(layouts: Sequence[Layout]) -> list[Feature]:
    """Return the features of the longest of these layouts, with bounds that hold for all.

    The layouts differ only in their bounds, and in features of the longest that some lack.
    """
    bounds: dict[str, list[float]] = {}
    for each in (feature for layout in layouts for feature in layout):
        bounds.setdefault(each.name, []).extend((each.low, each.high))
    return [
        replace(each, low=min(bounds[each.name]), high=max(bounds[each.name]))
        for each in max(layouts, key=len)
    ]
