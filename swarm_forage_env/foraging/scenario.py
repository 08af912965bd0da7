"""Scenario of foraging: that of e-pucks, with nests and prey areas. Origins: `epuck.parts`."""

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Self

import numpy as np
from pydantic import Field, field_validator, model_validator

from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.epuck.obstacles import ROUNDING
from swarm_forage_env.epuck.parts import Mission
from swarm_forage_env.epuck.records import AREAS
from swarm_forage_env.epuck.scenario import EpuckScenario
from swarm_forage_env.foraging.areas import MAX_AREAS, Area, in_order
from swarm_forage_env.parameters import Positive, list_as

if TYPE_CHECKING:
    from swarm_forage_env.foraging.episode import ForagingEpisode


class Task(Mission):
    """Foraging task: the areas, in addition to the parameters of a mission."""

    area_radius: Positive = Field(
        0.1, description="Radius of the nest and of the prey area [m]. TR Table 2 (published)"
    )
    area_distance: Positive = Field(
        1.5,
        description="Distance between the centres of nest and prey area [m], which lie on the"
        " long axis, symmetric about the arena's centre. Not in the papers (derived)",
    )
    areas: tuple[Area, ...] = Field(
        (),
        description="Nests and prey areas [m], instead of the two that area_distance places;"
        " none: those two. Not in the papers (chosen)",
    )

    _from_text = field_validator("areas", mode="before")(
        list_as('[{"kind": "nest", "centre": [-0.7, 0]}, {"centre": [0.7, 0]}]')
    )

    @model_validator(mode="after")
    def _has_both_kinds(self) -> Self:
        if len(self.areas) > MAX_AREAS:
            raise ValueError(
                f"task.areas: {len(self.areas)} areas; at most {MAX_AREAS} are possible"
            )
        for kind in AREAS:
            if self.areas and kind not in {area.kind for area in self.areas}:
                raise ValueError(f"task.areas: no area of the kind '{kind}'; give at least one")
        return self


class Scenario(EpuckScenario):
    """Parameters of a world of foraging."""

    task: Task = Task()

    if TYPE_CHECKING:
        _episode: type[ForagingEpisode]

    def check_areas(self) -> None:
        """Raise ValueError for areas outside the arena, on each other, in the start circle, or on
        an obstacle."""
        task, arena, places = self.task, self.arena, self.task.areas or self.places
        half_x, half_y, radius = 0.5 * arena.length, 0.5 * arena.width, task.area_radius
        inside, away = "move it inside, or make it smaller", "move it away from the origin"
        if not task.areas:
            inside = (
                f"area_distance may be at most {arena.length - 2.0 * radius:g}, area_radius at most"
                f" {min(half_x, half_y):g} [m]"
            )
            away = f"area_distance must be at least {2.0 * (task.start_radius + radius):g} [m]"
        for number, area in enumerate(places):
            name = f"areas[{number}]" if task.areas else f"area_distance={task.area_distance}"
            subject = f"task.{name}: the {area.kind} area of radius {radius} m"
            for x, y in area.centres:
                if max(abs(x) - half_x, abs(y) - half_y) + radius > ROUNDING:
                    raise ValueError(
                        f"{subject} about ({x:g}, {y:g}) lies outside the arena of {arena.length} x"
                        f" {arena.width} m; {inside}"
                    )
                for other in range(number):
                    apart = min(math.dist((x, y), centre) for centre in places[other].centres)
                    if apart < 2.0 * radius - ROUNDING:
                        raise ValueError(
                            f"{subject} about ({x:g}, {y:g}) overlaps task.areas[{other}] before or"
                            " after its move; keep them apart"
                        )
                self._check_clear(f"the {area.kind} area", (x, y), radius)
            if math.hypot(*area.centre) < task.start_radius + radius - ROUNDING:
                raise ValueError(
                    f"{subject} about ({area.centre[0]:g}, {area.centre[1]:g}) reaches into the"
                    f" start circle of radius {task.start_radius} m; {away}"
                )

    @property
    def unread(self) -> Mapping[str, str]:
        """Parameters without effect, each with the one that replaces it."""
        return {"task.area_distance": "task.areas"} if self.task.areas else {}

    @property
    def places(self) -> tuple[Area, ...]:
        """All areas: the first nest, the first prey area, then the others."""
        if self.task.areas:
            return in_order(self.task.areas)
        half = 0.5 * self.task.area_distance
        return Area(kind="nest", centre=(-half, 0.0)), Area(kind="prey", centre=(half, 0.0))

    @property
    def areas(self) -> Float64[Array, "areas 2"]:
        """Centres of the first nest and the first prey area at the start, world frame [m]."""
        return np.array([area.centre for area in self.places[:2]])

    @property
    def false_place_distance(self) -> float:
        """Half the distance between the first nest and the first prey area [m]."""
        return 0.5 * math.dist(*self.areas)
