"""Policy interfaces of foraging: observation, action and replaced layers of each `learn=`."""

from dataclasses import replace

import numpy as np

from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.compiler import kernel
from swarm_forage_env.epuck.records import Action, Command, Heard, Readings
from swarm_forage_env.epuck.task import MOTION, STEERINGS, WHEELS, slots
from swarm_forage_env.foraging.records import WORDS, Exchange, PolicyMessages, RobotState, Situation
from swarm_forage_env.observed_fields import FieldPath, paths
from swarm_forage_env.policy_interface import PolicyInterface, Steering
from swarm_forage_env.spaces import Feature, Layout
from swarm_forage_env.ticks import Arrays

_ENCOUNTER = paths(
    "encounter",
    "minds.estimator.exchange",
    Exchange,
    "is_valid own_p heard_p own_known heard_known disagreement own_distance heard_distance range"
    " n_averaged goal",
)

_SITUATION = (
    *paths("situation", "robots.readings", Readings, "proximity ground"),
    *paths(
        "situation", "minds.estimator.situation", Situation, "target areas p known goal is_talking"
    ),
    FieldPath("situation", "robots.heard", Heard, "is_valid", label="heard"),
    *paths("situation", "robots.heard", Heard, "range_bearing"),
    *paths("situation", "robots.command", Command, "wheels"),
)

_WALK = (
    FieldPath(
        "situation", "minds.estimator.situation", Situation, "walk", label="target.direction"
    ),
)

_RAW = (
    *paths("readings", "robots.readings", Readings, "proximity ground odometry"),
    *paths("heard", "robots.heard", Heard, "is_valid range_bearing n_averaged"),
    *paths("heard", "minds", PolicyMessages, "heard"),
)


@kernel
def course_to_command(speed: float, angle: float, sharpest_turn: float) -> tuple[float, float]:
    """Return the share of the cruise speed, min(1, 1 + speed), and the angle off the course."""
    return min(1.0, 1.0 + speed), angle


_WEIGHTS = paths("", "robots.action", Action, "weight")


FORAGING_STEERINGS = {
    **STEERINGS,
    "course": Steering(
        Layout(
            (
                Feature("course.speed", "-1 stands, 0 is the cruise speed", -1.0, 1.0),
                Feature("course.angle", "of 60 degrees off the course, to the left", -1.0, 1.0),
            )
        ),
        choices=((1.0, 0.0), (1.0, 0.5), (1.0, -0.5), (1.0, 1.0), (1.0, -1.0), (-1.0, 0.0)),
        command=course_to_command,
        is_course=True,
    ),
}
"""Forms of steering, including those that need a goal."""

N_SYMBOLS = 4
"""Number of messages in the discrete actions of `learn="everything"`, besides silence."""


def symbols() -> Float32[Array, "choices numbers"]:
    """Return the messages of discrete actions: silence, or one of the first words set to 1."""
    messages = np.zeros((1 + N_SYMBOLS, 1 + WORDS), np.float32)
    messages[0, 0], messages[1:, 0] = -1.0, 1.0
    messages[1:, 1 : 1 + N_SYMBOLS] = np.eye(N_SYMBOLS)
    return messages


_STEERING = replace(MOTION, observes=_SITUATION, target="situation.target", walk=_WALK)

LEARNABLE = {
    "weighting": PolicyInterface(_ENCOUNTER, _WEIGHTS, ("weighting",), slots),
    "motion": _STEERING,
    "both": replace(
        _STEERING,
        observes=_ENCOUNTER + _SITUATION,
        gives=_WEIGHTS + WHEELS,
        replaces=("weighting", "motion"),
        decision_period=1,
    ),
    "everything": PolicyInterface(
        _RAW,
        WHEELS + paths("", "minds", PolicyMessages, "speak words"),
        (),
        slots,
        decision_period=5,
        messages=symbols(),
    ),
}
"""Policy interfaces by the value of `learn`."""


@kernel
def apply_action(robot: RobotState, messages: PolicyMessages) -> None:
    """Write the command of a robot from the action of a policy of everything.

    Such a robot has no beliefs and never reports itself lost; an area that it has visited counts as
    known.
    """
    robot.command.is_speaking = messages.speak > 0.0
    for k in range(2):
        robot.command.wheels[k] = robot.action.wheels[k]
        robot.report.known[k] = robot.first_visit[k] >= 0


@kernel
def hear_words(world_arrays: Arrays, minds: Array, w: int, i: int) -> None:
    """Write the words in each message slot of robot i of world w; zeros in empty slots."""
    messages, heard = world_arrays[0][w, i].heard, minds[w, i].heard
    for slot in range(heard.shape[0]):
        for k in range(WORDS):
            heard[slot, k] = 0.0
            if slot < messages.n:
                heard[slot, k] = minds[w, messages.sender[slot]].words[k]
