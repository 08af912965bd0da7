"""Arenas with polygons of walls and with obstacles, after the mission generator MG1 of IRIDIA.

MG1 draws missions for swarms of 15 to 20 e-pucks: the shape of the arena, none to three obstacles,
and the positions of the areas. Side lengths, the distance of obstacles from the centre, their
lengths, and the distance of the areas from the centre are those of its square and its hexagon.

Not in the source: the dodecagon, which is that of IRIDIA's laboratory (4.91 m2, Francesca et al.
2014; obstacles as in the hexagon); the thickness of the obstacles; the choice among the four
obstacles (here: in order, the first two across the path between the areas); robots that start in a
circle; and the length of an episode, in MG1 at most three minutes.

Source: Ligot et al. 2022, and its code, github.com/demiurge-project/MissionGeneratorMG1.
"""

import math
from dataclasses import dataclass

from swarm_forage_env.epuck.obstacles import Obstacle, Point, regular_polygon, rounded
from swarm_forage_env.epuck.parts import Arena
from swarm_forage_env.foraging.scenario import Scenario, Task
from swarm_forage_env.registry import ORIGINS, SCENARIOS

THICKNESS = 0.01
"""Thickness of an obstacle [m]."""

OF_THE_WAY = 2.0 / 3.0
"""Distance of the areas from the arena's centre, as a share of the circumradius."""

MARGIN = 0.01
"""Margin of the rectangle around a polygon [m]."""


@dataclass(frozen=True)
class Shape:
    """Regular polygon with obstacles."""

    n_sides: int
    side: float
    """Length of a side [m]."""
    ring: float
    """Distance of an obstacle from the centre, as a share of the circumradius."""
    obstacle: float
    """Length of an obstacle [m]."""


SHAPES = {
    "square": Shape(4, 1.94, 1.0 / 3.0, 0.45),
    "hexagon": Shape(6, 1.29, math.cos(math.pi / 6) / 3.0, 0.35),
    "dodecagon": Shape(12, 0.66, math.cos(math.pi / 6) / 3.0, 0.35),
}

DIRECTIONS = ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0))
"""Directions of the obstacles from the centre, in the order in which they are placed."""


def across(direction: Point, distance: float, length: float) -> Obstacle:
    """Return a straight wall at a distance from the origin, at right angles to the direction."""
    (x, y), half = direction, 0.5 * length
    middle = distance * x, distance * y
    ends = (
        rounded(middle[0] - half * y, middle[1] + half * x),
        rounded(middle[0] + half * y, middle[1] - half * x),
    )
    return Obstacle(points=ends, radius=0.5 * THICKNESS)


def mg1(shape: str, n_obstacles: int = 2) -> Scenario:
    """Return the scenario `mg1-<shape>`, an arena of this shape with none to four obstacles."""
    form = SHAPES[shape]
    size = form.side / (2.0 * math.sin(math.pi / form.n_sides))  # the circumradius [m]
    distance = form.ring * size
    return Scenario(
        name=f"mg1-{shape}",
        arena=Arena(
            length=round(2.0 * (size + MARGIN), 4),
            width=round(2.0 * (size + MARGIN), 4),
            corners=regular_polygon(form.n_sides, size),
        ),
        obstacles=tuple(across(each, distance, form.obstacle) for each in DIRECTIONS[:n_obstacles]),
        task=Task(
            n_robots=20,
            area_radius=0.15,
            area_distance=round(2.0 * OF_THE_WAY * size, 4),
            start_radius=0.25,
        ),
    )


for shape in SHAPES:
    about = f"a {shape} of walls with two obstacles"
    SCENARIOS.register(f"mg1-{shape}", about)(mg1(shape))
    source = "IRIDIA's laboratory (published)" if shape == "dodecagon" else "MG1 (published)"
    ORIGINS[f"mg1-{shape}"] = {
        "arena.length": "Large enough for the polygon (derived)",
        "arena.width": "Large enough for the polygon (derived)",
        "arena.corners": source,
        "obstacles": "MG1, but for their thickness (published)",
        "task.n_robots": "MG1, the largest swarm (published)",
        "task.area_radius": "MG1, the smallest (published)",
        "task.area_distance": "MG1, two thirds of the way to a corner (published)",
        "task.start_radius": "Inside the ring of obstacles (chosen)",
    }
