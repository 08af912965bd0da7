"""Control of robots that visit waypoints; all share one estimator, as they correct it jointly."""

import math
from typing import Any

from swarm_forage_env.interface import KEEP, Kernel
from swarm_forage_env.record import Numbers, Record
from swarm_forage_env.templates import row_template
from swarm_forage_env.ticks import NOT_FINITE, Arrays, Errors, note
from swarm_forage_env.waypoints.records import RobotState

update_belief: Kernel
describe: Kernel
steer: Kernel
gain: Kernel
merge: Kernel
"""Free names of the templates: functions of the chosen layers."""


Mind = Any
"""Record of the chosen estimator for one robot, with the fields `situation`, `exchange` and
`belief`; `belief.pose` is the estimated pose [m, m, rad]."""


@row_template
def observe_world(world_arrays: Arrays, layer_arrays: Arrays, w: int, n_robots: int) -> None:
    """Update the beliefs of the robots of a world, then the inputs of their other layers."""
    swarm, sightings = world_arrays[0][w], world_arrays[1][w]
    minds, shared, settings = layer_arrays[0][w], layer_arrays[2][w], layer_arrays[3][w]
    last = settings.shape[0] - 1
    for i in range(n_robots):
        update_belief(minds[i], shared[i], swarm[i].readings, settings[min(i, last)].estimator)
    for i in range(n_robots):
        numbers = settings[min(i, last)].estimator
        describe(minds, i, sightings, swarm[i].readings, numbers)


@row_template
def act(robot: RobotState, mind: Mind, memory: Record, settings: Numbers) -> bool:
    """Write the command and the weight of a robot; returns whether both are finite."""
    situation, exchange, action = mind.situation, mind.exchange, robot.action
    acceleration = robot.command.acceleration
    if action.motion == KEEP:
        steer(situation, robot.readings, acceleration, memory, settings.motion)
    else:
        acceleration[0], acceleration[1] = action.acceleration[0], action.acceleration[1]
    robot.command.claim = situation.has_arrived > 0.0
    is_usable = math.isfinite(acceleration[0] + acceleration[1])
    if exchange.is_valid:
        if action.weighting == KEEP:
            exchange.weight[0] = gain(exchange, 0, settings.weighting)
        else:
            exchange.weight[0] = action.weight[0]
        is_usable = is_usable and math.isfinite(exchange.weight[0])
    return is_usable


@row_template
def decide_world(
    world_arrays: Arrays, layer_arrays: Arrays, errors: Errors, w: int, n_robots: int
) -> None:
    """Write the commands of the robots of a world, and correct their estimates jointly.

    Accelerations are decided before the merge, so that both layers use the same observation. If
    robots have different layers, the merge follows the decisions of the last ones. Accelerations
    and weights that are not finite are reported in `errors`.
    """
    robots, sightings = world_arrays[0], world_arrays[1]
    minds, memories, shared, settings = layer_arrays
    n_exchanges, last = 0, settings.shape[1] - 1
    for i in range(n_robots):
        own = settings[w, min(i, last)]
        n_exchanges += minds[w, i].exchange.is_valid > 0.0
        if own.is_member and not act(robots[w, i], minds[w, i], memories[w, i], own):
            note(errors, w, NOT_FINITE, i)
    if n_exchanges > 0 and settings[w, 0].is_last:
        merge(minds[w], shared[w], sightings[w], settings[w, 0].estimator)
