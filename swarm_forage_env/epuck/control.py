"""Control of e-pucks without an estimator: a motion as in foraging, with an empty situation."""

import math

import numpy as np

from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.compiler import kernel
from swarm_forage_env.epuck.records import Action, EpuckState
from swarm_forage_env.interface import CORRECT, KEEP, Kernel
from swarm_forage_env.record import Numbers, Record, field
from swarm_forage_env.templates import row_template
from swarm_forage_env.ticks import NOT_FINITE, Arrays, Errors, note

lane: Kernel
lanes: Kernel
steer: Kernel
"""Free names of the templates: lanes, and the motion."""

RESIDUAL_GAIN = 2.0
"""Wheel speed that a residual of 1 adds: full speed backwards becomes full speed ahead."""


class NoSituation(Record):
    """Empty situation of a robot without an estimator."""

    nothing: float = field(np.float32)


class NoMind(Record):
    """State of a robot without an estimator."""

    situation: NoSituation = field(NoSituation)


@row_template
def act(robot: EpuckState, mind: NoMind, memory: Record, settings: Numbers) -> bool:
    """Steer a robot, which always broadcasts; return whether its wheel speeds are finite."""
    action, wheels = robot.action, robot.command.wheels
    if action.motion == KEEP or action.motion == CORRECT:
        steer(mind.situation, robot.readings, robot.heard, wheels, memory, settings.motion)
    apply_wheels(action, False, wheels)
    robot.command.is_speaking = True
    return math.isfinite(wheels[0] + wheels[1])


@row_template
def steer_world(
    world_arrays: Arrays, layer_arrays: Arrays, errors: Errors, w: int, n_robots: int
) -> None:
    """Steer the robots of a world; note NOT_FINITE for wheel speeds that are not finite."""
    minds, memories, _, settings = layer_arrays
    last = settings.shape[1] - 1
    for i in range(lane(), n_robots, lanes()):
        own = settings[w, min(i, last)]
        if own.is_member and not act(world_arrays[0][w, i], minds[w, i], memories[w, i], own):
            note(errors, w, NOT_FINITE, i)


@kernel
def apply_wheels(action: Action, is_talking: bool, wheels: Float32[Array, "2"]) -> None:
    """Replace the wheel speeds of the motion by an action, or add the action to them.

        wheels = clip(own + RESIDUAL_GAIN residual, -1, 1)

    Nothing is added while the robot talks, as communication takes control of the motors
    (TR, Section 5.2).

    Source: Silver2018, Residual Policy Learning (arXiv:1812.06298), for the sum.
    """
    if action.motion == KEEP or (action.motion == CORRECT and is_talking):
        return
    for side in range(2):
        if action.motion == CORRECT:
            corrected = wheels[side] + np.float32(RESIDUAL_GAIN) * action.wheels[side]
            wheels[side] = min(max(corrected, -1.0), 1.0)
        else:
            wheels[side] = action.wheels[side]
