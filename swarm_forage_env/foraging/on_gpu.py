"""What a GPU needs of the foraging task beside the templates that it shares with a CPU."""

import numpy as np

from swarm_forage_env.arrays import Array, Float64, Int64, UInt64
from swarm_forage_env.compiler import kernel
from swarm_forage_env.equations.random_draws import first_word
from swarm_forage_env.foraging.floor import put_areas_back
from swarm_forage_env.foraging.global_state import put_counts, put_log
from swarm_forage_env.foraging.potential import potential
from swarm_forage_env.foraging.records import RobotState, WorldState
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.foraging.scoring import place_in_circle
from swarm_forage_env.foraging.surroundings import list_by_robots
from swarm_forage_env.foraging.world import SOURCES
from swarm_forage_env.interface import GpuTask, Kernel
from swarm_forage_env.random_streams import NoiseSource
from swarm_forage_env.record import Record
from swarm_forage_env.templates import row_template
from swarm_forage_env.ticks import NO_ROOM, Arrays, note

lane: Kernel
lanes: Kernel
barrier: Kernel
"""Free names of the template."""

PLACE = int(NoiseSource.PLACE)
CAUSES = tuple(map(int, SOURCES))
"""What each column of a robot's streams is for."""


def restarts(scenario: Scenario) -> bool:
    """Whether a GPU resets worlds of this scenario: faults are drawn in NumPy."""
    return not scenario.faults.is_any


@row_template
def place_world(  # noqa: PLR0913 what robots start from, and where they are placed
    world_arrays: Arrays,
    first_robot: RobotState,
    seed: np.uint64,
    places: UInt64[Array, " robots"],
    poses: Float64[Array, "robots 3"],
    trouble: Int64[Array, " worlds_and_one"],
    w: int,
    n_robots: int,
) -> None:
    """Put the robots of a new world at their starting places, and their streams at its seed.

    The first lane places all robots, as each keeps clear of those before it. Actions stay as they
    were. Free names: lane, lanes, barrier.
    """
    robots, world = world_arrays[0], world_arrays[1][w]
    for i in range(lane(), n_robots, lanes()):
        places[i] = first_word(seed, i, PLACE)
    barrier()
    if n_robots > 0 and lane() == 0:
        world.ticks, world.has_moved = 0, False
        put_areas_back(world)
        if place_in_circle(world.start_radius, 2.0 * world.radius, places, poses) < n_robots:
            note(trouble, w, NO_ROOM, 0)
    barrier()
    for i in range(lane(), n_robots, lanes()):
        action = robots[w, i].action
        weighting, motion = action.weighting, action.motion
        g_nest, g_prey = action.weight[0], action.weight[1]
        left, right = action.wheels[0], action.wheels[1]
        robots[w, i] = first_robot
        robot = robots[w, i]
        robot.action.weighting, robot.action.motion = weighting, motion
        robot.action.weight[0], robot.action.weight[1] = g_nest, g_prey
        robot.action.wheels[0], robot.action.wheels[1] = left, right
        for k in range(3):
            robot.pose[k] = poses[i, k]
        for column in range(len(CAUSES)):
            robot.streams[column] = first_word(seed, i, CAUSES[column])


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
