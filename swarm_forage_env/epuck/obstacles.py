"""Obstacles of a scenario: discs, walls and polygons of walls, and distances from them."""

import math
from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import Self

import numpy as np
from pydantic import Field, model_validator

from swarm_forage_env.compiler import plain
from swarm_forage_env.equations import obstacles
from swarm_forage_env.equations.obstacles import Capsules
from swarm_forage_env.parameters import NotNegative, Parameters

Point = tuple[float, float]

ROUNDING = 1e-9
"""Tolerance of overlaps [m]: circles and walls that overlap by less only touch."""

from_axis = plain(obstacles.from_axis)


class Obstacle(Parameters):
    """Obstacle to robots: a disc, a wall, a chain of walls, or a polygon of walls.

    One point and a radius make a disc. Two points make a straight wall, more points a chain of
    walls, and a closed chain is a polygon.
    """

    points: tuple[Point, ...] = Field(
        ((0.0, 0.0),),
        min_length=1,
        description="Corners in order, or the centre of a disc, world frame [m]. (chosen)",
    )
    radius: NotNegative = Field(
        0.0, description="Radius of a disc; half the thickness of walls [m]. (chosen)"
    )
    is_closed: bool = Field(
        False, description="Whether a wall joins the last point to the first one. (chosen)"
    )

    @model_validator(mode="after")
    def _has_a_body(self) -> Self:
        if len(self.points) == 1 and self.radius == 0.0:
            raise ValueError(
                f"obstacles: points={list(self.points)}, radius=0: a single point is a disc and"
                " needs a radius above 0 [m]"
            )
        if self.is_closed and len(self.points) < 3:
            raise ValueError(
                f"obstacles: points={list(self.points)}, is_closed=true: a polygon has at least 3"
                " points"
            )
        return self


def sides(points: Sequence[Point], is_closed: bool) -> list[tuple[Point, Point]]:
    """Return the two ends of each wall; a single point is paired with itself."""
    if len(points) == 1:
        return [(points[0], points[0])]
    pairs = list(pairwise(points))
    return [*pairs, (points[-1], points[0])] if is_closed else pairs


def capsules_of(every: Iterable[Obstacle], corners: Sequence[Point]) -> Capsules:
    """Return the capsules of all obstacles, then those of the outer wall with these corners."""
    walls = [(side, each.radius) for each in every for side in sides(each.points, each.is_closed)]
    walls += [(side, 0.0) for side in (sides(corners, True) if corners else [])]
    capsules = [(*a, *b, radius) for (a, b), radius in walls]
    return np.array(capsules, np.float64).reshape(-1, 5)


def regular_polygon(n_sides: int, circumradius: float) -> tuple[Point, ...]:
    """Return the corners of a regular polygon, counter-clockwise from the x axis [m]."""
    angles = [2.0 * math.pi * k / n_sides for k in range(n_sides)]
    return tuple(rounded(circumradius * math.cos(a), circumradius * math.sin(a)) for a in angles)


def rounded(x: float, y: float) -> Point:
    """Return a point [m] rounded to a tenth of a millimetre."""
    return round(x, 4) + 0.0, round(y, 4) + 0.0  # adding zero turns -0.0 into 0.0


def is_inside(place: Point, corners: Sequence[Point]) -> bool:
    """Return whether a place is inside a polygon: a ray from it crosses an odd number of sides.

    Source: textbook (even-odd rule).
    """
    x, y = place
    crossings = 0
    for (ax, ay), (bx, by) in sides(corners, True):
        if (ay > y) != (by > y) and x < ax + (y - ay) / (by - ay) * (bx - ax):
            crossings += 1
    return crossings % 2 == 1


def distance_from(place: Point, capsules: Capsules) -> float:
    """Return the distance from a place to the nearest capsule [m]; infinite if there is none."""
    return min(
        (math.hypot(*from_axis(*place, capsule)) - capsule[4] for capsule in capsules),
        default=math.inf,
    )
