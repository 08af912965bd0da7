"""The control of one robot in a tick: what its estimator does before the cut, and what follows it.

Templates whose free names are bound to the functions of the chosen layers: those of one robot, and
`observe` and `decide`, which run them over worlds and robots. At the cut between the two a learner,
or a rule written in NumPy, writes the actions that take the place of a layer.

A layer's functions receive records of the robot's interface only: never its pose. Every robot has
its own numbers; robots of another controller, which are not `is_member`, are left alone.
"""

import math
from typing import Any

import numpy as np

from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.compiler import kernel
from swarm_forage_env.foraging.fault_effects import is_lying, is_stale
from swarm_forage_env.foraging.fault_record import Lie
from swarm_forage_env.foraging.inputs import clear_exchange
from swarm_forage_env.foraging.records import Action, Exchange, RobotState
from swarm_forage_env.interface import CORRECT, KEEP, Kernel
from swarm_forage_env.record import Numbers, Record
from swarm_forage_env.templates import row_template

is_listening: Kernel
compose: Kernel
take_in: Kernel
listen: Kernel
describe: Kernel
steer: Kernel
gain: Kernel
merge: Kernel
has_something_to_say: Kernel
"""Free names of the templates: functions of the chosen layers."""

Mind = Any
"""What the chosen estimator keeps of a robot: a record."""

REACH = 2.0
"""Wheels that a correction of 1 adds: full speed back becomes full speed ahead."""


@kernel
def repeat(mind: Record) -> None:
    """Repeat nothing: stands for the function of an estimator that has none."""


@kernel
def falsify(mind: Record, lie: Lie) -> None:
    """Falsify nothing: stands for the function of an estimator that has none."""


@kernel
def is_weighed(exchange: Exchange, area: int) -> bool:
    """Both robots of the exchange know where the area is, so that there is something to weigh."""
    return bool(exchange.own_known[area]) and bool(exchange.heard_known[area])


@kernel
def is_asked(exchange: Exchange, area: int, numbers: Record) -> bool:
    """Ask the weighting about what both robots know, unless the estimator has its own function."""
    return is_weighed(exchange, area)


@row_template
def compose_message(robot: RobotState, mind: Mind, numbers: Numbers) -> None:
    """Compose the message of a robot that somebody listens to; faults change what was composed.

    Free names: compose, repeat, falsify.
    """
    compose(mind, numbers)
    if is_stale(robot):
        repeat(mind)
    if is_lying(robot):
        falsify(mind, robot.fault.lie)
    mind.is_composed = True


@row_template
def take_in_all(swarm: Array, crowd: Array, i: int, shared: Array, numbers: Numbers) -> None:
    """Take in what robot i sensed and heard, and describe what it is to decide on.

    Free names: take_in, listen, describe.
    """
    mind = crowd[i]
    take_in(mind, shared, swarm[i].readings, numbers)
    if mind.exchange.is_valid:
        clear_exchange(mind.exchange)
    mind.exchange.is_valid = listen(crowd, i, swarm[i].heard, numbers)
    describe(mind, swarm[i].report)


def observe(
    robots: Array, minds: Array, shared: Array, settings: Array, first: int, last: int
) -> None:
    """Take in what was sensed and heard, in the worlds first .. last - 1.

    A message is composed when somebody listens to it, before anybody's estimate moves. That of a
    robot with another estimator is never composed, and so tells nothing.
    Free names: is_listening; those of compose_message and of take_in_all.
    """
    for w in range(first, last):
        swarm, crowd, own = robots[w], minds[w], settings[w]
        for i in range(swarm.shape[0]):
            if own[i].is_member and is_listening(crowd[i]):
                for slot in range(swarm[i].heard.n):
                    j = swarm[i].heard.sender[slot]
                    if own[j].is_member and not crowd[j].is_composed:
                        compose_message(swarm[j], crowd[j], own[j].estimator)
        for i in range(swarm.shape[0]):
            if own[i].is_member:
                take_in_all(swarm, crowd, i, shared[w, i], own[i].estimator)


@row_template
def act(robot: RobotState, mind: Mind, memory: Record, shared: Array, settings: Numbers) -> bool:
    """Steer a robot, merge what it heard, choose whether it speaks; are all its numbers finite?

    The wheels are decided before the merge: both layers go by what one observation shows.
    Free names: steer, is_asked, gain, merge, has_something_to_say.
    """
    situation, exchange, action = mind.situation, mind.exchange, robot.action
    wheels = robot.command.wheels
    if action.motion == KEEP or action.motion == CORRECT:
        steer(situation, robot.readings, robot.heard, wheels, memory, settings.motion)
    take_wheels(action, situation.is_talking > 0.0, wheels)
    is_finite = math.isfinite(wheels[0] + wheels[1])
    if exchange.is_valid:
        for area in range(2):
            if is_asked(exchange, area, settings.estimator):
                exchange.weight[area] = gain(exchange, area, settings.weighting)
        take_weights(action, exchange)
        is_finite = is_finite and has_finite_weights(exchange)
        merge(mind, shared, settings.weighting.heard_p_share, settings.estimator)
    robot.command.is_speaking = has_something_to_say(mind, settings.estimator)
    mind.is_composed = False
    return is_finite


def decide(robots: Array, minds: Array, shared: Array, layers: Array, first: int, last: int) -> int:
    """Steer, merge what was heard, and choose whether to speak, in the worlds first .. last - 1.

    Returns a robot whose wheels or weights are not finite, as world * robots + robot, or else -1.
    Free names: those of act.
    """
    at_fault = -1
    for w in range(first, last):
        for i in range(robots.shape[1]):
            if not layers[w, i].is_member:
                continue
            mind = minds[w, i]
            if not act(robots[w, i], mind.estimator, mind.motion, shared[w, i], layers[w, i]):
                at_fault = w * robots.shape[1] + i
    return at_fault


@kernel
def has_finite_weights(exchange: Exchange) -> bool:
    """Every weight that the robot merges with is finite."""
    for area in range(2):
        if is_weighed(exchange, area) and not math.isfinite(exchange.weight[area]):
            return False
    return True


@kernel
def take_weights(action: Action, exchange: Exchange) -> None:
    """Put an action in the place of the weights."""
    if action.weighting != KEEP:
        exchange.weight[0], exchange.weight[1] = action.weight[0], action.weight[1]


@kernel
def take_wheels(action: Action, is_talking: bool, wheels: Float32[Array, "2"]) -> None:
    """Put an action in the place of the wheels, or add it to those of the motion.

        wheels = clip(own + REACH residual, -1, 1)

    To a robot that is talking nothing is added, as communication takes control of the motors
    (TR, Section 5.2).

    Source: Silver2018, Residual Policy Learning (arXiv:1812.06298), for the sum.
    """
    if action.motion == KEEP or (action.motion == CORRECT and is_talking):
        return
    for side in range(2):
        if action.motion == CORRECT:
            corrected = wheels[side] + np.float32(REACH) * action.wheels[side]
            wheels[side] = min(max(corrected, -1.0), 1.0)
        else:
            wheels[side] = action.wheels[side]
