"""Policies in the waypoints world: observations, actions and replaced layers of each `learn=`."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.compiler import kernel
from swarm_forage_env.equations.steering import drive_to_pull
from swarm_forage_env.observed_fields import FieldPath, layout_of, paths
from swarm_forage_env.policy_interface import PolicyInterface, Steering
from swarm_forage_env.spaces import Feature, Layout
from swarm_forage_env.ticks import Arrays
from swarm_forage_env.waypoints.records import (
    WORDS,
    Action,
    Command,
    Exchange,
    PolicyMessages,
    Readings,
    RobotState,
    Sighting,
    Situation,
)
from swarm_forage_env.waypoints.scenario import WaypointsScenario

_ENCOUNTER = paths(
    "encounter",
    "minds.estimator.exchange",
    Exchange,
    "is_valid neighbours own_covariance_norm heard_covariance_norm disagreement",
)

_SITUATION = (
    *paths(
        "situation",
        "minds.estimator.situation",
        Situation,
        "goal home centre separation alignment velocity density covariance_norm"
        " dead_reckoning_offset has_arrived",
    ),
    *paths("situation", "robots.command", Command, "acceleration"),
)

_RAW = (
    *paths("readings", "robots.readings", Readings, "motion compass at_home home_fix goal"),
    *(
        FieldPath("heard", "sightings", Sighting, name, each="robots")
        for name in ("seen", "range", "bearing")
    ),
    *paths("heard", "minds", PolicyMessages, "heard"),
)

_WEIGHT, _PULL = (paths("", "robots.action", Action, name) for name in ("weight", "acceleration"))


def robots(scenario: WaypointsScenario) -> Mapping[str, int]:
    """Return the size of the axis `robots` in a scenario: the number of robots."""
    return {"robots": scenario.task.n_robots}


STEERINGS = {
    "drive": Steering(
        Layout(
            (
                Feature("drive.strength", "-1 goes straight on, 1 is the highest", -1.0, 1.0),
                Feature("drive.turn", "of the sharpest turn, to the left", -1.0, 1.0),
            )
        ),
        choices=((-1.0, 0.0), (1.0, 0.0), (1.0, 1.0), (1.0, -1.0), (0.0, 0.0)),
        command=drive_to_pull,
    ),
    "pull": Steering(
        layout_of(_PULL, {}, None),
        choices=((0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.0, -1.0), (-1.0, 0.0)),
    ),
}
"""Forms of steering, by the value of `action`; the first is the default."""

N_SYMBOLS = 2
"""Number of messages besides silence in the discrete actions of `learn=everything`."""


def symbols() -> Float32[Array, "choices numbers"]:
    """Return the messages of discrete actions: a claim or none, with no word or a single one."""
    messages = np.zeros((2, 1 + N_SYMBOLS, 1 + WORDS), np.float32)
    messages[0, :, 0], messages[1, :, 0] = -1.0, 1.0
    messages[:, 1:, 1 : 1 + N_SYMBOLS] = np.eye(N_SYMBOLS)
    return messages.reshape(-1, 1 + WORDS)


_MOTION = PolicyInterface(_SITUATION, _PULL, ("motion",), target="situation.goal")

LEARNABLE = {
    "weighting": PolicyInterface(_ENCOUNTER, _WEIGHT, ("weighting",)),
    "motion": _MOTION,
    "both": replace(
        _MOTION,
        observes=_ENCOUNTER + _SITUATION,
        gives=_WEIGHT + _PULL,
        replaces=("weighting", "motion"),
    ),
    "everything": PolicyInterface(
        _RAW,
        _PULL + paths("", "minds", PolicyMessages, "claim words"),
        (),
        robots,
        messages=symbols(),
        target="readings.goal",
    ),
}
"""Policy interfaces, by the value of `learn`."""


@kernel
def apply_action(robot: RobotState, messages: PolicyMessages) -> None:
    """Write the claim and the acceleration of a policy to the command of its robot."""
    robot.command.claim = messages.claim > 0.0
    for k in range(2):
        robot.command.acceleration[k] = robot.action.acceleration[k]


@kernel
def hear_words(world_arrays: Arrays, minds: Array, w: int, i: int) -> None:
    """Write the messages of the robots that robot i of world w sees; zeros for other robots."""
    sightings, heard = world_arrays[1], minds[w, i].heard
    for j in range(heard.shape[0]):
        for k in range(WORDS):
            heard[j, k] = minds[w, j].words[k] if sightings[w, i, j].seen else 0.0
