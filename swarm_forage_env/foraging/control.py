"""The control of one robot in a tick: what its estimator does before the cut, and what follows it.

Two templates whose free names are bound to the functions of the chosen layers. At the cut between
them a learner, or a rule written in NumPy, writes the actions that take the place of a layer.

A layer's functions receive records of the robot's interface only: never its pose. Every robot has
its own numbers; robots of another controller, which are not `is_member`, are left alone.
"""

import math

import numpy as np

from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.compiler import kernel
from swarm_forage_env.foraging.fault_effects import is_lying, is_stale
from swarm_forage_env.foraging.fault_record import Lie
from swarm_forage_env.foraging.records import Action, Exchange
from swarm_forage_env.interface import CORRECT, KEEP, Kernel
from swarm_forage_env.record import Record

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

REACH = 2.0
"""Wheels that a correction of 1 adds: full speed back becomes full speed ahead."""


@kernel
def repeat(mind: Record) -> None:
    """Repeat nothing: stands for the function of an estimator that has none."""


@kernel
def falsify(mind: Record, lie: Lie) -> None:
    """Falsify nothing: stands for the function of an estimator that has none."""


def observe(  # noqa: C901 a template: only in it are free names bound
    robots: Array, minds: Array, shared: Array, settings: Array, first: int, last: int
) -> None:
    """Take in what was sensed and heard, in the worlds first .. last - 1.

    A message is composed when somebody listens to it, before anybody's estimate moves. That of a
    robot with another estimator is never composed, and so tells nothing. Faults change what was
    composed.
    Free names: is_listening, compose, repeat, falsify, take_in, listen, describe.
    """
    for w in range(first, last):
        swarm, crowd, own = robots[w], minds[w], settings[w]
        for i in range(swarm.shape[0]):
            if own[i].is_member and is_listening(crowd[i]):
                for slot in range(swarm[i].heard.n):
                    j = swarm[i].heard.sender[slot]
                    if own[j].is_member and not crowd[j].is_composed:
                        compose(crowd[j], own[j].estimator)
                        if is_stale(swarm[j]):
                            repeat(crowd[j])
                        if is_lying(swarm[j]):
                            falsify(crowd[j], swarm[j].fault.lie)
                        crowd[j].is_composed = True
        for i in range(swarm.shape[0]):
            if own[i].is_member:
                numbers = own[i].estimator
                take_in(crowd[i], shared[w, i], swarm[i].readings, numbers)
                crowd[i].exchange.is_valid = listen(crowd, i, swarm[i].heard, numbers)
                describe(crowd[i], swarm[i].report)


def decide(robots: Array, minds: Array, shared: Array, layers: Array, first: int, last: int) -> int:
    """Steer, merge what was heard, and choose whether to speak, in the worlds first .. last - 1.

    The wheels are decided before the merge: both layers go by what one observation shows. Returns
    a robot whose wheels or weights are not finite, as world * robots + robot, or else -1.
    Free names: steer, gain, merge, has_something_to_say.
    """
    at_fault = -1
    for w in range(first, last):
        for i in range(robots.shape[1]):
            settings = layers[w, i]
            if not settings.is_member:
                continue
            robot, mind, memory = robots[w, i], minds[w, i].estimator, minds[w, i].motion
            situation, exchange, action = mind.situation, mind.exchange, robot.action
            wheels = robot.command.wheels
            if action.motion == KEEP or action.motion == CORRECT:
                steer(situation, robot.readings, robot.heard, wheels, memory, settings.motion)
            take_wheels(action, situation.is_talking, wheels)
            at_fault = check_finite(wheels, at_fault, w * robots.shape[1] + i)
            if exchange.is_valid:
                for area in range(2):
                    if is_weighed(exchange, area):
                        exchange.weight[area] = gain(exchange, area, settings.weighting)
                take_weights(action, exchange)
                at_fault = check_weights(exchange, at_fault, w * robots.shape[1] + i)
                merge(mind, shared[w, i], settings.weighting.heard_p_share, settings.estimator)
            robot.command.is_speaking = has_something_to_say(mind, settings.estimator)
            mind.is_composed = False
    return at_fault


@kernel
def check_finite(numbers: Float32[Array, "2"], at_fault: int, robot: int) -> int:
    """The robot, if one of its two numbers is not finite; else who was at fault before."""
    return at_fault if math.isfinite(numbers[0] + numbers[1]) else robot


@kernel
def check_weights(exchange: Exchange, at_fault: int, robot: int) -> int:
    """The robot, if a weight that it merges with is not finite; else who was at fault before."""
    for area in range(2):
        if is_weighed(exchange, area) and not math.isfinite(exchange.weight[area]):
            return robot
    return at_fault


@kernel
def is_weighed(exchange: Exchange, area: int) -> bool:
    """Both robots of the exchange know where the area is, so that there is something to weigh."""
    return bool(exchange.own_known[area]) and bool(exchange.heard_known[area])


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
