"""Control of foraging robots in a tick: estimators in `observe_world`, the rest in `decide_world`.

Between the two a learner, or a rule written in NumPy, writes the actions that replace a layer.

A layer's functions receive only records of the robot's interface, never its pose. Every robot has
its own parameters; robots of another controller (`is_member` is false) are skipped.
"""

import math
from typing import Any

from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.compiler import kernel
from swarm_forage_env.epuck.control import apply_wheels
from swarm_forage_env.epuck.fault_draws import is_lying
from swarm_forage_env.epuck.fault_record import STALE, Fault
from swarm_forage_env.epuck.records import Action
from swarm_forage_env.equations.differential_drive import wheels_towards
from swarm_forage_env.equations.elementary import atan2
from swarm_forage_env.equations.geometry import wrap
from swarm_forage_env.foraging.inputs import clear_exchange, goal_of
from swarm_forage_env.foraging.records import Exchange, RobotState, Situation, WorldState
from swarm_forage_env.interface import CORRECT, COURSE, KEEP, Kernel
from swarm_forage_env.record import Numbers, Record
from swarm_forage_env.templates import row_template
from swarm_forage_env.ticks import NOT_FINITE, Arrays, Errors, note, nothing

lane: Kernel
lanes: Kernel
barrier: Kernel
is_listening: Kernel
compose: Kernel
update_belief: Kernel
update_exchange: Kernel
describe: Kernel
steer: Kernel
gain: Kernel
merge: Kernel
has_something_to_say: Kernel
"""Free names of the templates: lanes, and functions of the chosen layers."""

Mind = Any
"""Record of the chosen estimator for one robot."""

WIDEST_OFF_COURSE = math.pi / 3.0
"""Largest angle at which a learner can steer off the course [rad] (chosen)."""


repeat = falsify = walk = nothing
"""Defaults for an estimator without falsifiable messages, and for a motion without a walk."""


@kernel
def reflex(*handed: object) -> bool:
    """Return false, as no reflex steered: the default of a motion without reflexes."""
    return False


@kernel
def is_weighed(exchange: Exchange, area: int) -> bool:
    """Return whether both robots of the exchange know the area, so that it can be weighed."""
    return bool(exchange.own_known[area]) and bool(exchange.heard_known[area])


@kernel
def needs_weight(exchange: Exchange, area: int, numbers: Record) -> bool:
    """Return whether the weighting is called for an area; estimators can replace this function."""
    return is_weighed(exchange, area)


@row_template
def compose_message(
    robot: RobotState, fault: Fault, world: WorldState, mind: Mind, numbers: Numbers
) -> None:
    """Compose the message of a robot; faults may change it."""
    compose(mind, numbers)
    if robot.is_faulty[STALE]:
        repeat(mind)
    if is_lying(robot, fault, world):
        falsify(mind, fault.lie)


@row_template
def update_and_describe(
    swarm: Array, minds: Array, i: int, shared: Array, numbers: Numbers
) -> None:
    """Update the belief of robot i by readings and messages; describe it for the other layers."""
    mind = minds[i]
    update_belief(mind, shared, swarm[i].readings, numbers)
    mind.exchange.is_valid = update_exchange(minds, i, swarm[i].heard, numbers)
    describe(mind, swarm[i].report)


@row_template
def mark_heard(swarm: Array, minds: Array, i: int, settings: Array) -> None:
    """Mark the messages that robot i receives from robots with its estimator, if it listens."""
    last = settings.shape[0] - 1
    if settings[min(i, last)].is_member and is_listening(minds[i]):
        for slot in range(swarm[i].heard.n):
            j = swarm[i].heard.sender[slot]
            if settings[min(j, last)].is_member and not minds[j].is_composed:
                minds[j].is_heard = True


@row_template
def observe_world(world_arrays: Arrays, layer_arrays: Arrays, w: int, n_robots: int) -> None:
    """Update the beliefs of the robots of a world by their readings and messages.

    Messages with a listener are composed before any estimate changes. Robots with the same
    parameters share one column of `settings`.
    """
    swarm, world, faults = world_arrays[0][w], world_arrays[1][w], world_arrays[6][w]
    minds, shared = layer_arrays[0][w], layer_arrays[2][w]
    own, last = layer_arrays[3][w], layer_arrays[3].shape[1] - 1
    for i in range(lane(), n_robots, lanes()):
        mark_heard(swarm, minds, i, own)
    barrier()
    for i in range(lane(), n_robots, lanes()):
        if minds[i].is_heard:
            numbers = own[min(i, last)]
            compose_message(swarm[i], faults[i], world, minds[i], numbers.estimator)
            minds[i].is_heard, minds[i].is_composed = False, True
    barrier()
    for i in range(lane(), n_robots, lanes()):
        numbers = own[min(i, last)]
        if numbers.is_member:
            update_and_describe(swarm, minds, i, shared[i], numbers.estimator)


@row_template
def move(robot: RobotState, situation: Situation, memory: Record, settings: Numbers) -> None:
    """Set the wheel speeds of a robot: by the motion, a learner, or reflexes that override it."""
    action, wheels, numbers = robot.action, robot.command.wheels, settings.motion
    is_free = True
    if action.motion == KEEP or action.motion == CORRECT:
        steer(situation, robot.readings, robot.heard, wheels, memory, numbers)
    elif action.has_reflexes:
        is_free = not reflex(situation, robot.readings, wheels, memory, numbers)
    if is_free and action.motion == COURSE:
        steer_off_course(situation, action, wheels)
    elif is_free:
        apply_wheels(action, situation.is_talking > 0.0, wheels)
    if action.is_walking:
        walk(situation, wheels, is_free, memory, numbers)


@row_template
def act(robot: RobotState, mind: Mind, memory: Record, shared: Array, settings: Numbers) -> bool:
    """Steer a robot, merge the received estimate, and choose whether to broadcast.

    The wheel speeds are set before the merge, so that both layers use one observation. Returns
    whether the wheel speeds are finite and the weights are in [0, 1].
    """
    exchange, action, wheels = mind.exchange, robot.action, robot.command.wheels
    move(robot, mind.situation, memory, settings)
    is_usable = math.isfinite(wheels[0] + wheels[1])
    if exchange.is_valid:
        for area in range(2):
            if needs_weight(exchange, area, settings.estimator):
                exchange.weight[area] = gain(exchange, area, settings.weighting)
        if action.weighting != KEEP:
            exchange.weight[0], exchange.weight[1] = action.weight[0], action.weight[1]
        is_usable = is_usable and weighs_by_shares(exchange)
        merge(mind, shared, settings.weighting.heard_p_share, settings.estimator)
        clear_exchange(exchange)
    robot.command.is_speaking = has_something_to_say(mind, settings.estimator)
    mind.is_composed = False
    return is_usable


@kernel
def steer_off_course(situation: Situation, action: Action, wheels: Float32[Array, "2"]) -> None:
    """Steer at an angle off the course to the target, or without a goal off that of the walk.

    angle  = atan2(course) + a_1 WIDEST_OFF_COURSE
    wheels = a_0 wheels_towards(angle)
    """
    course = situation.target if goal_of(situation.goal) >= 0 else situation.walk
    angle = wrap(atan2(course[1], course[0]) + action.wheels[1] * WIDEST_OFF_COURSE)
    left, right = wheels_towards(angle, 0.0)
    wheels[0], wheels[1] = action.wheels[0] * left, action.wheels[0] * right


@row_template
def decide_world(
    world_arrays: Arrays, layer_arrays: Arrays, errors: Errors, w: int, n_robots: int
) -> None:
    """Steer the robots of a world, merge received estimates, and choose which robots broadcast.

    Notes NOT_FINITE for wheel speeds that are not finite or weights outside [0, 1].
    """
    robots = world_arrays[0]
    minds, memories, shared, settings = layer_arrays
    last = settings.shape[1] - 1
    for i in range(lane(), n_robots, lanes()):
        own = settings[w, min(i, last)]
        if own.is_member and not act(robots[w, i], minds[w, i], memories[w, i], shared[w, i], own):
            note(errors, w, NOT_FINITE, i)


@kernel
def weighs_by_shares(exchange: Exchange) -> bool:
    """Return whether all weights of the merge are in [0, 1]."""
    for area in range(2):
        if is_weighed(exchange, area) and not 0.0 <= exchange.weight[area] <= 1.0:
            return False
    return True
