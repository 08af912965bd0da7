"""Scenarios with more than two areas, of differing worth, or with one that moves.

Twenty robots for half an hour in an arena of 3 x 2 m; radio, sensors and robots are those of es1.
"""

from swarm_forage_env.epuck.parts import Arena
from swarm_forage_env.foraging.areas import Area
from swarm_forage_env.foraging.scenario import Scenario, Task
from swarm_forage_env.registry import ORIGINS, SCENARIOS

NEST = Area(kind="nest", centre=(-0.8, 0.0))


def with_areas(name: str, *areas: Area) -> Scenario:
    """The scenario of that name with these areas."""
    return Scenario(
        name=name,
        arena=Arena(length=3.0, width=2.0),
        task=Task(n_robots=20, start_radius=0.25, areas=areas),
    )


TWO_PREY = with_areas(
    "two-prey", NEST, Area(centre=(0.3, 0.75)), Area(centre=(1.2, -0.5), worth=3.0)
)
"""A poor prey area near the nest, and a rich one farther away."""

MOVING_PREY = with_areas(
    "moving-prey", NEST, Area(centre=(0.7, 0.5), moves_at=900.0, moves_to=(0.7, -0.5))
)
"""After a quarter of an hour the prey area lies a metre from where it was, as far from the nest."""

TWO_NESTS = with_areas(
    "two-nests",
    Area(kind="nest", centre=(-0.8, 0.6)),
    Area(kind="nest", centre=(-0.8, -0.6)),
    Area(centre=(0.7, 0.0)),
)
"""Two nests, equally far from the prey area."""

ABOUT = {
    "two-prey": "a poor prey area near the nest, and a rich one farther away",
    "moving-prey": "the prey area moves once, in mid-episode",
    "two-nests": "two nests, equally far from the prey area",
}
"""What each scenario is, in words."""

for scenario in (TWO_PREY, MOVING_PREY, TWO_NESTS):
    SCENARIOS.register(scenario.name, ABOUT[scenario.name])(scenario)
    ORIGINS[scenario.name] = {
        "arena.length": "Room for the areas (chosen)",
        "arena.width": "Room for the areas (chosen)",
        "task.n_robots": "Twice those of es1 (chosen)",
        "task.start_radius": "Room for the robots (chosen)",
        "task.areas": "What the scenario is about (chosen)",
    }
