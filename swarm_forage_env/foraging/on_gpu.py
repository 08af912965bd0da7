"""What a GPU needs of the foraging task beside the templates that it shares with a CPU."""

from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.compiler import kernel
from swarm_forage_env.epuck.placing import place_world
from swarm_forage_env.epuck.surroundings import list_by_robots
from swarm_forage_env.foraging.global_state import put_counts, put_log
from swarm_forage_env.foraging.potential import potential
from swarm_forage_env.foraging.records import RobotState, WorldState
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.interface import GpuTask
from swarm_forage_env.record import Record


def restarts(scenario: Scenario) -> bool:
    """Whether a GPU resets worlds of this scenario: faults are drawn in NumPy."""
    return not scenario.faults.is_any


@kernel
def log_beliefs(
    robot: RobotState, mind: Record, world: WorldState, row: Float64[Array, " infos"]
) -> None:
    """Write what is logged of a robot that believes something."""
    put_log(robot, mind.situation, world, row)  # type: ignore[attr-defined]  # every estimator has one


@kernel
def log_counts(
    robot: RobotState,
    mind: Record,
    world: WorldState,
    row: Float64[Array, " infos"],
) -> None:
    """Write what is logged of a robot of a policy of everything: it believes nothing."""
    put_counts(robot, row)
    row[4] = row[5] = 0.0


ON_GPU = GpuTask(
    functions={"list_neighbours": list_by_robots},
    place=place_world,
    restarts=restarts,
    robot=RobotState,
    log={True: log_beliefs, False: log_counts},
    potential=potential,
)
