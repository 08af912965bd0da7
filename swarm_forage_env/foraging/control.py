"""The control of one robot in a tick: what its estimator does before the cut, and what follows it.

Two templates whose free names are bound to the functions of the chosen layers. At the cut between
them a learner, or a rule written in NumPy, writes the actions that take the place of a layer.

A layer's functions receive records of the robot's interface only: never its pose.
"""

import numpy as np

from swarm_forage_env.arrays import Array
from swarm_forage_env.compiler import kernel
from swarm_forage_env.foraging.records import Action, Command
from swarm_forage_env.interface import CORRECT, KEEP

REACH = 2.0
"""Wheels that a correction of 1 adds: full speed back becomes full speed ahead."""


def observe(
    robots: Array, minds: Array, shared: Array, numbers: Array, first: int, last: int
) -> None:
    """Take in what was sensed and heard, in the worlds first .. last - 1.

    A message is composed when somebody listens to it, before anybody's estimate moves.
    Free names: is_listening, compose, take_in, listen, describe.
    """
    for w in range(first, last):
        swarm, crowd = robots[w], minds[w]
        for i in range(swarm.shape[0]):
            if is_listening(crowd[i]):
                for slot in range(swarm[i].heard.n):
                    sender = crowd[swarm[i].heard.sender[slot]]
                    if not sender.is_composed:
                        compose(sender, numbers[w])
                        sender.is_composed = True
        for i in range(swarm.shape[0]):
            take_in(crowd[i], shared[w, i], swarm[i].readings, numbers[w])
            crowd[i].exchange.is_valid = listen(crowd, i, swarm[i].heard, numbers[w])
            describe(crowd[i], swarm[i].report)


def decide(
    robots: Array, minds: Array, shared: Array, layers: Array, first: int, last: int
) -> None:
    """Steer, merge what was heard, and choose whether to speak, in the worlds first .. last - 1.

    The wheels are decided before the merge: both layers go by what one observation shows.
    Free names: steer, gain, merge, has_something_to_say.
    """
    for w in range(first, last):
        settings = layers[w]
        for i in range(robots.shape[1]):
            robot, mind, memory = robots[w, i], minds[w, i].estimator, minds[w, i].motion
            situation, exchange, action = mind.situation, mind.exchange, robot.action
            if action.motion == KEEP or action.motion == CORRECT:
                last_wheels = robot.command.wheels
                steer(
                    situation, robot.readings, robot.heard, last_wheels, memory, settings.motion
                )
            if action.motion != KEEP:
                take_wheels(action, situation.is_talking, robot.command)
            if exchange.is_valid:
                for area in range(2):
                    if action.weighting != KEEP:
                        exchange.weight[area] = action.weight[area]
                    elif exchange.own_known[area] and exchange.heard_known[area]:
                        exchange.weight[area] = gain(exchange, area, settings.weighting)
                merge(mind, shared[w, i], settings.weighting.heard_p_share, settings.estimator)
            robot.command.is_speaking = has_something_to_say(mind, settings.estimator)
            mind.is_composed = False


@kernel
def take_wheels(action: Action, is_talking: bool, command: Command) -> None:
    """Put an action in the place of the wheels, or add it to those of the motion.

        wheels = clip(own + REACH residual, -1, 1)

    To a robot that is talking nothing is added, as communication takes control of the motors
    (TR, Section 5.2).

    Source: Silver2018, Residual Policy Learning (arXiv:1812.06298), for the sum.
    """
    for side in range(2):
        if action.motion == CORRECT:
            if not is_talking:
                sum_ = command.wheels[side] + np.float32(REACH) * action.wheels[side]
                command.wheels[side] = min(max(sum_, -1.0), 1.0)
        else:
            command.wheels[side] = action.wheels[side]
