"""The control of robots in a tick: what estimators do before the cut, and what follows it.

At the cut between `observe_world` and `decide_world` a learner, or a rule written in NumPy, writes
the actions that replace a layer.

A layer's functions receive records of the robot's interface only: never its pose. Every robot has
its own numbers; robots of another controller, which are not `is_member`, are left alone.
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
from swarm_forage_env.ticks import NOT_FINITE, Arrays, Trouble, note, nothing

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
"""What the chosen estimator keeps of a robot: a record."""

WIDEST_OFF_COURSE = math.pi / 3.0
"""How far off the course to its target or of its walk a learner can steer [rad] (chosen)."""


repeat = falsify = walk = nothing
"""Of an estimator whose messages no fault can change, and of a motion that has no walk."""


@kernel
def reflex(*handed: object) -> bool:
    """Do nothing: the default of a motion that has no reflexes. Whether one steered."""
    return False


@kernel
def is_weighed(exchange: Exchange, area: int) -> bool:
    """Both robots of the exchange know where the area is, so that there is something to weigh."""
    return bool(exchange.own_known[area]) and bool(exchange.heard_known[area])


@kernel
def is_asked(exchange: Exchange, area: int, numbers: Record) -> bool:
    """Ask the weighting about what both robots know, unless the estimator has its own function."""
    return is_weighed(exchange, area)


@row_template
def compose_message(
    robot: RobotState, fault: Fault, world: WorldState, mind: Mind, numbers: Numbers
) -> None:
    """Compose the message of a robot that somebody listens to; faults change what was composed."""
    compose(mind, numbers)
    if robot.is_faulty[STALE]:
        repeat(mind)
    if is_lying(robot, fault, world):
        falsify(mind, fault.lie)


@row_template
def update_and_describe(
    swarm: Array, minds: Array, i: int, shared: Array, numbers: Numbers
) -> None:
    """Update the belief of robot i by what it sensed and heard; describe it to the other layers."""
    mind = minds[i]
    update_belief(mind, shared, swarm[i].readings, numbers)
    mind.exchange.is_valid = update_exchange(minds, i, swarm[i].heard, numbers)
    describe(mind, swarm[i].report)


@row_template
def mark_heard(swarm: Array, minds: Array, i: int, settings: Array) -> None:
    """Mark the messages that robot i listens to, of those who have its estimator."""
    last = settings.shape[0] - 1
    if settings[min(i, last)].is_member and is_listening(minds[i]):
        for slot in range(swarm[i].heard.n):
            j = swarm[i].heard.sender[slot]
            if settings[min(j, last)].is_member and not minds[j].is_composed:
                minds[j].is_heard = True


@row_template
def observe_world(world_arrays: Arrays, layer_arrays: Arrays, w: int, n_robots: int) -> None:
    """Update what the robots of a world believe by what was sensed and heard.

    Messages to which somebody listens are composed before anybody's estimate moves. Robots that
    have the same numbers share the one column of `settings`.
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
    """Turn the wheels of a robot: by the motion, by a learner, or by reflexes before it."""
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
    """Steer a robot, merge what it heard, choose whether it speaks; can its numbers be used?

    The wheels are decided before the merge: both layers use one observation.
    """
    exchange, action, wheels = mind.exchange, robot.action, robot.command.wheels
    move(robot, mind.situation, memory, settings)
    is_usable = math.isfinite(wheels[0] + wheels[1])
    if exchange.is_valid:
        for area in range(2):
            if is_asked(exchange, area, settings.estimator):
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
    """Steer off the course to the target, or without a goal off that of the walk.

    angle  = atan2(course) + a_1 WIDEST_OFF_COURSE
    wheels = a_0 wheels_towards(angle)
    """
    course = situation.target if goal_of(situation.goal) >= 0 else situation.walk
    angle = wrap(atan2(course[1], course[0]) + action.wheels[1] * WIDEST_OFF_COURSE)
    left, right = wheels_towards(angle, 0.0)
    wheels[0], wheels[1] = action.wheels[0] * left, action.wheels[0] * right


@row_template
def decide_world(
    world_arrays: Arrays, layer_arrays: Arrays, trouble: Trouble, w: int, n_robots: int
) -> None:
    """Steer, merge what was heard, and choose whether to speak, in a world.

    A robot whose wheels are not finite, or whose weights are no shares, is noted.
    """
    robots = world_arrays[0]
    minds, memories, shared, settings = layer_arrays
    last = settings.shape[1] - 1
    for i in range(lane(), n_robots, lanes()):
        own = settings[w, min(i, last)]
        if own.is_member and not act(robots[w, i], minds[w, i], memories[w, i], shared[w, i], own):
            note(trouble, w, NOT_FINITE, i)


@kernel
def weighs_by_shares(exchange: Exchange) -> bool:
    """Every weight that the robot merges with is from 0 to 1."""
    for area in range(2):
        if is_weighed(exchange, area) and not 0.0 <= exchange.weight[area] <= 1.0:
            return False
    return True
