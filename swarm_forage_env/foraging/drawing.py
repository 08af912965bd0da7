"""Drawing of a foraging world: its stage, and a scene for each tick."""

import numpy as np

from swarm_forage_env.arrays import NEST, PREY, Array, Float32, Float64, Int8, Int32
from swarm_forage_env.compiler import entry_point, kernel
from swarm_forage_env.epuck.drawing import bodies, walls
from swarm_forage_env.epuck.records import AREAS
from swarm_forage_env.equations.geometry import to_outer
from swarm_forage_env.foraging.areas import move_tick
from swarm_forage_env.foraging.records import RobotState, Situation
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.foraging.scoring import TO_NEST, TO_PREY
from swarm_forage_env.foraging.world import ForagingWorld
from swarm_forage_env.interface import Kernel
from swarm_forage_env.raw_control import has_estimators
from swarm_forage_env.record import rows
from swarm_forage_env.scene import (
    EXPLORING,
    LOST,
    TALKING,
    TO_THE_NEST,
    TO_THE_PREY,
    Scene,
    Stage,
    without_beliefs,
)
from swarm_forage_env.ticks import RUN, START, Arrays, Errors, Modes


def stage_of(scenario: Scenario, controller: str) -> Stage:
    """Return the stage of a scenario, with this name of the controller."""
    return Stage(
        controller=controller,
        areas=np.array([area.centre for area in scenario.places]),
        kinds=tuple(AREAS.index(area.kind) for area in scenario.places),
        names=tuple(
            area.kind if area.worth == 1.0 else f"{area.kind} x{area.worth:g}"
            for area in scenario.places
        ),
        moves=tuple(
            (k, move_tick(area.moves_at, scenario.tick) * scenario.tick, *area.moves_to)
            for k, area in enumerate(scenario.places)
            if area.moves_at is not None and area.moves_to is not None
        ),
        area_radius=scenario.task.area_radius,
        **walls(scenario),
    )


def scene_of(world: ForagingWorld, minds: Array, w: int = 0) -> Scene:
    """Return the scene of one world of a block; without beliefs if there is no estimator."""
    robots, n = world.robots[w].view(np.recarray), world.n_robots
    fields = without_beliefs(n) | bodies(world, w)
    if has_estimators(minds):
        situations = rows(minds["estimator"]["situation"][w])
        fields |= {"known": situations.known != 0, "p": situations.p.copy()}
        draw_robots(world.robots[w], situations, fields["activity"], fields["believed"])
    else:
        fields["activity"][robots.leg == TO_NEST] = TO_THE_NEST
        fields["activity"][robots.leg == TO_PREY] = TO_THE_PREY
    fields["round_trips"] = robots.round_trips.copy()
    fields["on_path"] = float(robots.known.all(axis=1).mean())
    return Scene(**fields)


@kernel
def activity_of(robot: RobotState, situation: Situation) -> int:
    """Return the code of the state of a robot."""
    if situation.is_talking > 0.0:
        return TALKING
    if situation.goal[PREY] > 0.0:
        return TO_THE_PREY
    if situation.goal[NEST] > 0.0:
        return TO_THE_NEST
    astray = robot.lost_events > 0 and robot.known[NEST] == 0 and robot.known[PREY] == 0
    return LOST if astray and situation.goal[2] > 0.0 else EXPLORING


@kernel
def believed_place(robot: RobotState, situation: Situation, area: int) -> tuple[float, float]:
    """Return the believed place of an area, world frame [m]; zeros if it is unknown."""
    if situation.known[area] == 0.0:
        return 0.0, 0.0
    ahead, left = situation.areas[area, 0], situation.areas[area, 1]
    dx, dy = to_outer(ahead, left, robot.heading[0], robot.heading[1])
    return robot.pose[0] + dx, robot.pose[1] + dy


@entry_point
def draw_robots(
    robots: Array,
    situations: Array,
    out_activity: Int8[Array, " robots"],
    out_believed: Float64[Array, "robots areas 2"],
) -> None:
    """Write the state of each robot of a world, and its believed places of nest and prey."""
    for i in range(robots.shape[0]):
        out_activity[i] = activity_of(robots[i], situations[i])
        for area in range(2):
            place = believed_place(robots[i], situations[i], area)
            out_believed[i, area, 0], out_believed[i, area, 1] = place


COLUMNS = (
    "x", "y", "heading", "doing", "known", "trips", "nestX", "nestY", "nestP", "preyX", "preyY",
    "preyP", "knowsWay", "faulty",
)  # fmt: skip
"""Columns that `draw_column` writes for each robot, by their names in a web page."""


@kernel
def draw_column(
    robot: RobotState, situation: Situation, i: int, out: Float32[Array, "columns robots"]
) -> None:
    """Write the columns of robot i."""
    for k in range(3):
        out[k, i] = robot.pose[k]
    out[3, i] = activity_of(robot, situation)
    out[4, i] = situation.known[NEST] + 2.0 * situation.known[PREY]
    out[5, i] = robot.round_trips
    for area in range(2):
        at = 6 + 3 * area
        out[at, i], out[at + 1, i] = believed_place(robot, situation, area)
        out[at + 2, i] = situation.p[area]
    out[12, i] = robot.known[NEST] != 0 and robot.known[PREY] != 0
    out[13, i] = robot.is_faulty.sum() > 0


run_ticks: Kernel
begin_worlds: Kernel
observe: Kernel
pilot: Kernel
"""Free names of the template below: the ticks of a world and its controller, its start, the
observations of a learner, and the actions of a policy."""


def run_and_draw(  # noqa: PLR0913 arguments of `run_ticks`, and outputs
    world_arrays: Arrays,
    layer_arrays: Arrays,
    modes: Modes,
    errors: Errors,
    starts: Arrays,
    noise: int,
    n_ticks: int,
    out_columns: Float32[Array, "columns robots"],
    out_pairs: Int32[Array, "messages ends"],
    observing: Arrays,
    piloting: Arrays,
) -> int:
    """Run ticks of one world, and write its drawing; return the number of messages received.

    A world in mode START is placed from its seed, then it senses and observes. `out_pairs`
    holds sender and receiver of each message of these ticks. `starts` and `noise` are those of
    `begin_worlds`; `observing` are the arguments of `observe` except modes and worlds; `piloting`
    are those of `pilot`.
    """
    robots, minds, n_heard = world_arrays[0], layer_arrays[0], 0
    if modes[0] == START:
        begin_worlds(world_arrays, layer_arrays, starts, noise, modes, errors)
        run_ticks(world_arrays, layer_arrays, modes, errors, 0, 1, 1)
        modes[0] = RUN
    for _ in range(n_ticks):
        pilot(robots, world_arrays[1][0].ticks, piloting)
        run_ticks(world_arrays, layer_arrays, modes, errors, 0, 1, 1)
        for i in range(robots.shape[1]):
            heard = robots[0, i].heard
            for slot in range(heard.n):
                out_pairs[n_heard, 0], out_pairs[n_heard, 1] = heard.sender[slot], i
                n_heard += 1
    for i in range(robots.shape[1]):
        draw_column(robots[0, i], minds[0, i].situation, i, out_columns)
    fields, learners, scaling, extras, rows = observing
    observe(fields, learners, scaling, extras, modes, rows, (0, 1))
    return n_heard
