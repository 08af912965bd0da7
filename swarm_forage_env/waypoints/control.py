"""The control of the robots of a world: what estimators do before the cut, and what follows it.

Two templates whose free names are bound to the functions of the chosen layers. At the cut between
them a learner, or a rule written in NumPy, writes the actions that take the place of a layer.

A layer's functions receive records of the robot's interface only: never its pose. Every robot has
its own weighting and motion; robots of other ones, which are not `is_member`, are left alone. The
estimator is that of the whole swarm, as robots correct their estimates jointly.
"""

import math

from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.compiler import kernel
from swarm_forage_env.interface import KEEP, Kernel
from swarm_forage_env.waypoints.records import Action

take_in: Kernel
describe: Kernel
steer: Kernel
gain: Kernel
merge: Kernel
"""Free names of the templates: functions of the chosen layers."""

Records = tuple[Array, Array]
"""Robots, worlds by robots, and sightings, worlds by robots by robots."""


def observe(
    records: Records, minds: Array, shared: Array, settings: Array, first: int, last: int
) -> None:
    """Take in what was sensed, in the worlds first .. last - 1, and describe what was seen.

    Free names: take_in, describe.
    """
    robots, sightings = records
    for w in range(first, last):
        swarm, crowd = robots[w], minds[w]
        for i in range(swarm.shape[0]):
            take_in(crowd[i], shared[w, i], swarm[i].readings, settings[w, i].estimator)
        for i in range(swarm.shape[0]):
            numbers = settings[w, i].estimator
            describe(crowd, i, sightings[w], swarm[i].readings, numbers)


def decide(
    records: Records, minds: Array, shared: Array, layers: Array, first: int, last: int
) -> int:
    """Steer, claim, and correct the estimates of all robots, in the worlds first .. last - 1.

    Accelerations are decided before the merge: both layers go by what one observation shows. Of
    robots that differ in their layers those that are decided last bring about the merge of all.
    Returns a robot whose acceleration or weight is not finite, as world * robots + robot, or else
    -1.
    Free names: steer, gain, merge.
    """
    robots, sightings = records
    at_fault = -1
    for w in range(first, last):
        n_exchanges = 0
        for i in range(robots.shape[1]):
            settings = layers[w, i]
            n_exchanges += minds[w, i].estimator.exchange.is_valid > 0.0
            if not settings.is_member:
                continue
            robot, mind, memory = robots[w, i], minds[w, i].estimator, minds[w, i].motion
            situation, exchange, action = mind.situation, mind.exchange, robot.action
            acceleration = robot.command.acceleration
            if action.motion == KEEP:
                steer(situation, robot.readings, acceleration, memory, settings.motion)
            take_acceleration(action, acceleration)
            at_fault = check_finite(acceleration, at_fault, w * robots.shape[1] + i)
            robot.command.claim = situation.has_arrived > 0.0
            if exchange.is_valid:
                if action.weighting == KEEP:
                    exchange.weight[0] = gain(exchange, 0, settings.weighting)
                else:
                    exchange.weight[0] = action.weight[0]
                at_fault = check_finite(exchange.weight, at_fault, w * robots.shape[1] + i)
        if n_exchanges > 0 and layers[w, 0].is_last:
            merge(minds[w].estimator, shared[w], sightings[w], layers[w, 0].estimator)
    return at_fault


@kernel
def check_finite(numbers: Float32[Array, " numbers"], at_fault: int, robot: int) -> int:
    """The robot, if one of its numbers is not finite; else who was at fault before."""
    for k in range(numbers.shape[0]):
        if not math.isfinite(numbers[k]):
            return robot
    return at_fault


@kernel
def take_acceleration(action: Action, acceleration: Float32[Array, "2"]) -> None:
    """Put an action in the place of the acceleration."""
    if action.motion != KEEP:
        acceleration[0], acceleration[1] = action.acceleration[0], action.acceleration[1]
