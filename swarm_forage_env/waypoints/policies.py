"""Policies in the waypoints world: what each `learn=` observes, gives and replaces."""

from typing import Any

import numpy as np

from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.compiler import entry_point, kernel
from swarm_forage_env.equations.steering import drive_to_pull
from swarm_forage_env.policy_interface import Groups, Index, PolicyInterface, Steering
from swarm_forage_env.record import Record, field
from swarm_forage_env.spaces import Feature, Layout
from swarm_forage_env.waypoints.observations import (
    PULL,
    UNIT,
    WORDS,
    correction_features,
    flock_features,
    reading_features,
    sighting_features,
)
from swarm_forage_env.waypoints.records import Exchange, RobotState, Situation
from swarm_forage_env.waypoints.scenario import WaypointsScenario
from swarm_forage_env.waypoints.views import MotionInput, WeightingInput

G = Feature("g", "weight", *UNIT)
"""The share of the correction by all neighbours that is carried out."""

PULLS = tuple(Feature(f"pull.{side}", "of the highest acceleration", *PULL) for side in ("x", "y"))

CLAIM = Feature("claim", "at the goal if > 0", *PULL)

SAID = tuple(Feature(f"words.{word}", "as sent", *PULL) for word in range(WORDS))


@kernel
def put_exchange(exchange: Exchange, out: Float32[Array, " numbers"], at: int) -> int:
    """Write the correction that is about to be made; where the next number goes."""
    out[at], out[at + 1] = exchange.is_valid, exchange.neighbours
    out[at + 2] = exchange.own_covariance_norm
    out[at + 3] = exchange.heard_covariance_norm
    out[at + 4] = exchange.disagreement
    return at + 5


@kernel
def put_situation(
    robot: RobotState, situation: Situation, out: Float32[Array, " numbers"], at: int
) -> int:
    """Write what the motion layer sees; where the next number goes."""
    for k in range(2):
        out[at + k], out[at + 2 + k] = situation.goal[k], situation.home[k]
        out[at + 4 + k], out[at + 6 + k] = situation.centre[k], situation.separation[k]
        out[at + 8 + k], out[at + 10 + k] = situation.alignment[k], situation.velocity[k]
        out[at + 16 + k] = robot.command.acceleration[k]
    out[at + 12], out[at + 13] = situation.density, situation.covariance_norm
    out[at + 14], out[at + 15] = situation.dead_reckoning_offset, situation.has_arrived
    return at + 18


@entry_point
def write_exchanges(
    robots: Array, minds: Array, out: Float32[Array, "worlds robots numbers"]
) -> None:
    """Write the observation of a learner of the weighting."""
    for w in range(out.shape[0]):
        for i in range(out.shape[1]):
            put_exchange(minds[w, i].exchange, out[w, i], 0)


@entry_point
def write_situations(
    robots: Array, minds: Array, out: Float32[Array, "worlds robots numbers"]
) -> None:
    """Write the observation of a learner of the motion."""
    for w in range(out.shape[0]):
        for i in range(out.shape[1]):
            put_situation(robots[w, i], minds[w, i].situation, out[w, i], 0)


@entry_point
def write_both(robots: Array, minds: Array, out: Float32[Array, "worlds robots numbers"]) -> None:
    """Write the observation of a learner of both layers."""
    for w in range(out.shape[0]):
        for i in range(out.shape[1]):
            at = put_exchange(minds[w, i].exchange, out[w, i], 0)
            put_situation(robots[w, i], minds[w, i].situation, out[w, i], at)


@kernel
def put_readings(robot: RobotState, out: Float32[Array, " numbers"]) -> int:
    """Write what the robot's own sensors say; where the next number goes."""
    readings = robot.readings
    out[0], out[1] = readings.motion[0], readings.motion[1]
    out[2], out[3] = readings.compass, readings.at_home
    for k in range(3):
        out[4 + k] = readings.home_fix[k]
    out[7], out[8] = readings.goal[0], readings.goal[1]
    return 9


@entry_point
def write_readings(
    robots: Array, sightings: Array, said: Array, out: Float32[Array, "worlds robots numbers"]
) -> None:
    """Write the observation of a learner of everything: readings, then who is seen and says what.

    What is said in a tick is heard after it by those who see the speaker.
    """
    n = out.shape[1]
    for w in range(out.shape[0]):
        for i in range(n):
            row = out[w, i]
            at = put_readings(robots[w, i], row)
            for j in range(n):
                sight = sightings[w, i, j]
                row[at + j], row[at + n + j] = sight.seen, sight.range
                row[at + 2 * n + j] = sight.bearing
                for k in range(WORDS):
                    to = at + 3 * n + j * WORDS + k
                    row[to] = said[w, j].words[k] if sight.seen else 0.0


class Said(Record):
    """What a learner of everything says and claims. Writer: the environment."""

    words: Float32[Array, "words"] = field(np.float32, WORDS)
    """The message, whose meaning is the policy's."""

    claim: bool = field(np.bool_)
    """The robot is at its goal: another one, please."""


@kernel
def carry_out(robot: RobotState, said: Said) -> None:
    """Command what the policy of a robot that visits waypoints says."""
    robot.command.claim = said.claim
    for k in range(2):
        robot.command.acceleration[k] = robot.action.acceleration[k]


def _weigh(world: Any, controller: Any, learners: Index, action: Array) -> None:  # noqa: ANN401 of its task
    world.robots["action"]["weight"][:, learners] = action


def _move(world: Any, controller: Any, learners: Index, action: Array) -> None:  # noqa: ANN401 of its task
    world.robots["action"]["acceleration"][:, learners] = action


def _do_both(world: Any, controller: Any, learners: Index, action: Array) -> None:  # noqa: ANN401 of its task
    _weigh(world, controller, learners, action[:, :, :1])
    _move(world, controller, learners, action[:, :, 1:])


def _do_everything(world: Any, controller: Any, learners: Index, action: Array) -> None:  # noqa: ANN401 of its task
    _move(world, controller, learners, action[:, :, :2])
    controller.minds["claim"][:, learners] = action[:, :, 2] > 0.0
    controller.minds["words"][:, learners] = action[:, :, 3:]


def _observe_exchanges(world: Any, controller: Any, out: Array) -> None:  # noqa: ANN401 of its task
    write_exchanges(world.robots, controller.minds["estimator"], out)


def _observe_situations(world: Any, controller: Any, out: Array) -> None:  # noqa: ANN401 of its task
    write_situations(world.robots, controller.minds["estimator"], out)


def _observe_both(world: Any, controller: Any, out: Array) -> None:  # noqa: ANN401 of its task
    write_both(world.robots, controller.minds["estimator"], out)


def _observe_readings(world: Any, controller: Any, out: Array) -> None:  # noqa: ANN401 of its task
    write_readings(world.robots, world.sightings, controller.minds, out)


def _encounter(scenario: WaypointsScenario) -> Groups:
    return {"encounter": correction_features()}


def _situation(scenario: WaypointsScenario) -> Groups:
    return {"situation": flock_features()}


def _both(scenario: WaypointsScenario) -> Groups:
    return {**_encounter(scenario), **_situation(scenario)}


def _raw(scenario: WaypointsScenario) -> Groups:
    return {"readings": reading_features(scenario), "heard": sighting_features(scenario)}


STEERINGS = {
    "drive": Steering(
        Layout(
            (
                Feature("drive.strength", "-1 goes straight on, 1 is the highest", *PULL),
                Feature("drive.turn", "of the sharpest turn, to the left", *PULL),
            )
        ),
        choices=((-1.0, 0.0), (1.0, 0.0), (1.0, 1.0), (1.0, -1.0), (0.0, 0.0)),
        command=drive_to_pull,
    ),
    "pull": Steering(
        Layout(PULLS),
        choices=((0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.0, -1.0), (-1.0, 0.0)),
    ),
}
"""How a policy can steer, by the name that `action` takes; the first is the usual one."""

N_SYMBOLS = 2
"""Messages among which a discrete action of everything chooses, beside silence."""


def symbols() -> Float32[Array, "choices numbers"]:
    """What a robot can say in a discrete action: a claim or none, and no word or one alone."""
    said = np.zeros((2, 1 + N_SYMBOLS, 1 + WORDS), np.float32)
    said[0, :, 0], said[1, :, 0] = -1.0, 1.0
    said[:, 1:, 1 : 1 + N_SYMBOLS] = np.eye(N_SYMBOLS)
    return said.reshape(-1, 1 + WORDS)


_INPUTS = {"encounter": WeightingInput, "situation": MotionInput}

LEARNABLE = {
    "weighting": PolicyInterface(
        Layout((G,)),
        _encounter,
        _observe_exchanges,
        _weigh,
        ("weighting",),
        _INPUTS,
        n_weights=1,
    ),
    "motion": PolicyInterface(
        Layout(PULLS),
        _situation,
        _observe_situations,
        _move,
        ("motion",),
        _INPUTS,
        is_steering=True,
        target="situation.goal",
    ),
    "both": PolicyInterface(
        Layout((G, *PULLS)),
        _both,
        _observe_both,
        _do_both,
        ("weighting", "motion"),
        _INPUTS,
        n_weights=1,
        is_steering=True,
        target="situation.goal",
    ),
    "everything": PolicyInterface(
        Layout((*PULLS, CLAIM, *SAID)),
        _raw,
        _observe_readings,
        _do_everything,
        (),
        {},
        is_steering=True,
        said=symbols(),
        target="readings.goal",
    ),
}
"""What a policy can take the place of, by the name that `learn` takes."""
