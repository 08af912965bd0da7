"""ForagingWorld: a block of worlds in which e-pucks forage."""

from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.epuck.world import EpuckWorld
from swarm_forage_env.foraging.areas import write_areas
from swarm_forage_env.foraging.records import RobotState, WorldState
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.foraging.scoring import brightness_at, move_areas, reset_areas, score


class ForagingWorld(
    EpuckWorld,
    robot=RobotState,
    world=WorldState,
    functions={
        "begin_world": reset_areas,
        "begin_tick": move_areas,
        "brightness_at": brightness_at,
        "score": score,
    },
):
    """Worlds of foraging e-pucks that run in parallel."""

    @property
    def areas(self) -> Float64[Array, "areas 2"]:
        """Current centres of the first nest and the first prey area in the first world [m]."""
        centres: Float64[Array, "areas 2"] = self.worlds["areas"][0, :2]
        return centres

    @staticmethod
    def write_task(scenario: Scenario, out_worlds: Array) -> None:
        """Write the areas, and the tick of half an episode."""
        out_worlds["half_time"] = scenario.n_ticks // 2
        out_worlds["area_radius"] = scenario.task.area_radius
        write_areas(scenario.places, scenario.tick, out_worlds)
