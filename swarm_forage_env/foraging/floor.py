"""The floor of a world: which area lies under a point, and the move of an area."""

import math

from swarm_forage_env.compiler import kernel
from swarm_forage_env.equations.elementary import hypot
from swarm_forage_env.equations.ground import FLOOR, area_at, brightness
from swarm_forage_env.foraging.records import WorldState


@kernel
def number_at(x: float, y: float, world: WorldState) -> int:
    """Which area of the world holds a point of the world frame [m]: its number, or FLOOR."""
    return area_at(x, y, world.areas, world.n_areas, world.area_radius)


@kernel
def kind_at(x: float, y: float, world: WorldState) -> int:
    """What lies under a point of the world frame [m]: NEST, PREY or FLOOR."""
    number = number_at(x, y, world)
    return FLOOR if number == FLOOR else int(world.kinds[number])


@kernel
def brightness_at(x: float, y: float, world: WorldState) -> float:
    """How bright the floor is under a point of the world frame [m]."""
    return brightness(kind_at(x, y, world))


@kernel
def distance_to_kind(x: float, y: float, kind: int, world: WorldState) -> float:
    """Distance from a point of the world frame to the nearest centre of that kind of area [m]."""
    nearest = math.inf
    for k in range(world.n_areas):
        if world.kinds[k] == kind:
            nearest = min(nearest, hypot(x - world.areas[k, 0], y - world.areas[k, 1]))
    return float(nearest)


@kernel
def reset_areas(world: WorldState) -> None:
    """Put all areas where they are at the start."""
    for k in range(world.n_areas):
        world.areas[k, 0], world.areas[k, 1] = world.first_places[k, 0], world.first_places[k, 1]


@kernel
def move_areas(world: WorldState) -> None:
    """Put the areas that move in this tick at their second places."""
    for k in range(world.n_areas):
        if world.ticks == world.moves_at[k]:
            world.areas[k, 0], world.areas[k, 1] = world.moves_to[k, 0], world.moves_to[k, 1]
