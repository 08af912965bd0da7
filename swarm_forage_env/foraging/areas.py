"""Areas of a scenario: nests and prey areas, their worth and their moves."""

from collections.abc import Sequence
from typing import Literal, Self

from pydantic import Field, model_validator

from swarm_forage_env.arrays import Array
from swarm_forage_env.epuck.obstacles import Point
from swarm_forage_env.epuck.records import AREAS
from swarm_forage_env.equations.ground import FLOOR
from swarm_forage_env.parameters import NotNegative, Parameters, Positive

MAX_AREAS = 8
"""Maximum number of areas in the record of a world."""

NEVER = -1
"""Value of `moves_at` of an area that never moves."""


class Area(Parameters):
    """A nest or a prey area: a circle of task.area_radius on the floor."""

    kind: Literal["nest", "prey"] = Field("prey", description="Kind of the area. (chosen)")
    centre: Point = Field((0.0, 0.0), description="Centre of the area, world frame [m]. (chosen)")
    worth: Positive = Field(
        1.0,
        description="Worth: a round trip pays that of its prey area times that of its nest."
        " (chosen)",
    )
    moves_at: NotNegative | None = Field(
        None, description="Time of its move, one in an episode; none: it stays [s]. (chosen)"
    )
    moves_to: Point | None = Field(None, description="Centre after the move [m]. (chosen)")

    @model_validator(mode="after")
    def _moves_whole(self) -> Self:
        if (self.moves_at is None) != (self.moves_to is None):
            raise ValueError(
                f"task.areas: {self.kind} at {self.centre}: give both moves_at and moves_to, or"
                " neither"
            )
        return self

    @property
    def centres(self) -> list[Point]:
        """Centres of the area during an episode, in order [m]."""
        return [self.centre] if self.moves_to is None else [self.centre, self.moves_to]


def in_order(areas: Sequence[Area]) -> tuple[Area, ...]:
    """Return the areas as in the records: the first nest, the first prey area, the others."""
    first = [next(area for area in areas if area.kind == kind) for kind in AREAS]
    return (*first, *(area for area in areas if all(area is not each for each in first)))


def write_areas(areas: Sequence[Area], tick: float, out_worlds: Array) -> None:
    """Write the areas in this order, at their first places, to records of worlds; `tick` in [s]."""
    out_worlds["n_areas"], out_worlds["kinds"] = len(areas), FLOOR
    for k, area in enumerate(areas):
        out_worlds["areas"][..., k, :] = out_worlds["first_places"][..., k, :] = area.centre
        out_worlds["kinds"][..., k] = AREAS.index(area.kind)
        out_worlds["worths"][..., k] = area.worth
        moves_at = NEVER if area.moves_at is None else move_tick(area.moves_at, tick)
        out_worlds["moves_at"][..., k] = moves_at
        out_worlds["moves_to"][..., k, :] = area.centres[-1]


def move_tick(moves_at: float, tick: float) -> int:
    """Return the tick from which an area is at its second place; `moves_at` and `tick` in [s]."""
    return max(1, round(moves_at / tick))
