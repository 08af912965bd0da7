"""Trajectories: what is kept of every robot in every tick, as columns of a table."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from swarm_forage_env.arrays import Array


@dataclass(frozen=True, slots=True)
class TrajectoryColumn:
    """One column: what a table calls it, its type, and what it is for a reader."""

    name: str
    kind: str
    """NumPy type: of the numbers, or of the codes of words."""

    text: str
    """What the column holds, with its unit."""

    words: tuple[str, ...] = ()
    """The word of each code, where the column holds words."""

    @property
    def is_nullable(self) -> bool:
        """The column may be empty: a float that is NaN, a code that is -1."""
        return bool(self.words) or self.kind.startswith("f")


@dataclass(frozen=True, slots=True)
class TrajectoryKind:
    """What the robots of a task leave behind in a tick."""

    columns: tuple[TrajectoryColumn, ...]
    take: Callable[[Any, Array], Mapping[str, Array]]
    """The columns as they stand now, each (worlds, robots), from a block and the minds of its
    robots. NaN and -1 stand for what there is not."""

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the columns."""
        return tuple(each.name for each in self.columns)
