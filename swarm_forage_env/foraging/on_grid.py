"""How a GPU runs the worlds of the foraging task."""

from swarm_forage_env.foraging.grid import (
    decide_on_grid,
    log_on_grid,
    observe_on_grid,
    tick_on_grid,
)
from swarm_forage_env.foraging.grid_reset import (
    forget_on_grid,
    place_on_grid,
    restarts,
    sense_first_on_grid,
)
from swarm_forage_env.foraging.potential import potential
from swarm_forage_env.foraging.records import RobotState
from swarm_forage_env.interface import GridTemplates, LayerTemplates

ON_GRID = GridTemplates(
    tick=tick_on_grid,
    place=place_on_grid,
    sense_first=sense_first_on_grid,
    restarts=restarts,
    robot=RobotState,
    layers=LayerTemplates(
        decide=decide_on_grid,
        observe=observe_on_grid,
        forget=forget_on_grid,
        log=log_on_grid,
    ),
    potential=potential,
)
