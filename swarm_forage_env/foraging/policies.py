"""Policies in the foraging world: what each `learn=` observes, gives and replaces."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.compiler import bind, inlined, kernel
from swarm_forage_env.equations.differential_drive import drive_to_wheels
from swarm_forage_env.foraging.bounds import Bounds
from swarm_forage_env.foraging.observations import (
    AREAS,
    SPEED,
    WHEELS,
    WORDS,
    encounter_features,
    heard_features,
    reading_features,
    situation_features,
)
from swarm_forage_env.foraging.records import Exchange, RobotState, Situation
from swarm_forage_env.foraging.views import MotionInput, WeightingInput
from swarm_forage_env.interface import Kernel
from swarm_forage_env.policy_interface import (
    Groups,
    Index,
    PolicyInterface,
    PolicyOnGrid,
    Steering,
)
from swarm_forage_env.record import Record, field
from swarm_forage_env.spaces import Feature, Layout

G = tuple(Feature(f"g.{area}", "weight", 0.0, 1.0) for area in AREAS)
"""The weight of what was heard about each area; of no effect where no exchange just ended."""

SPEEDS = tuple(Feature(f"wheels.{side}", "of cruise speed", *SPEED) for side in WHEELS)

SPEAK = Feature("speak", "broadcast if > 0", *SPEED)

SAID = tuple(Feature(f"words.{word}", "as sent", *SPEED) for word in range(WORDS))

Mind = Any
"""What an estimator keeps of a robot: a record."""

show: Kernel
"""Free name of the template: the observation of one robot."""


@kernel
def put_goal(goal: int, out: Float32[Array, " numbers"], at: int) -> int:
    """Write a goal as three numbers, one of which is 1: nest, prey, none; where the next goes."""
    for k in range(3):
        out[at + k] = 1.0 if k == goal or (k == 2 and goal < 0) else 0.0
    return at + 3


@kernel
def put_range_bearing(
    robot: RobotState, n_slots: int, out: Float32[Array, " numbers"], at: int
) -> int:
    """Write where the sender in each slot is; zeros for an empty one; where the next goes."""
    for slot in range(n_slots):
        for k in range(3):
            heard = slot < robot.heard.n
            out[at + 3 * slot + k] = robot.heard.range_bearing[slot, k] if heard else 0.0
    return at + 3 * n_slots


@kernel
def put_sensors(robot: RobotState, out: Float32[Array, " numbers"], at: int) -> int:
    """Write proximity and ground; where the next goes."""
    for k in range(8):
        out[at + k] = robot.readings.proximity[k]
    for k in range(3):
        out[at + 8 + k] = robot.readings.ground[k]
    return at + 11


@kernel
def put_exchange(exchange: Exchange, out: Float32[Array, " numbers"], at: int) -> int:
    """Write the exchange that just ended, zeros without one; where the next goes."""
    out[at] = exchange.is_valid
    if not exchange.is_valid:
        for k in range(1, 17):
            out[at + k] = 0.0
        return put_goal(-1, out, at + 17)
    for area in range(2):
        out[at + 1 + area] = exchange.own_p[area]
        out[at + 3 + area] = exchange.heard_p[area]
        out[at + 5 + area] = exchange.own_known[area]
        out[at + 7 + area] = exchange.heard_known[area]
        out[at + 9 + area] = exchange.disagreement[area]
        out[at + 11 + area] = exchange.own_distance[area]
        out[at + 13 + area] = exchange.heard_distance[area]
    out[at + 15], out[at + 16] = exchange.range, exchange.n_averaged
    return put_goal(exchange.goal, out, at + 17)


@kernel
def put_situation(
    robot: RobotState,
    situation: Situation,
    n_slots: int,
    out: Float32[Array, " numbers"],
    at: int,
) -> int:
    """Write what the motion layer sees; where the next goes."""
    at = put_sensors(robot, out, at)
    for k in range(2):
        out[at + k] = situation.target[k]
        out[at + 2 + k], out[at + 4 + k] = situation.areas[0, k], situation.areas[1, k]
        out[at + 6 + k] = situation.p[k]
        out[at + 8 + k] = situation.known[k]
    at = put_goal(situation.goal, out, at + 10)
    out[at] = situation.is_talking
    at += 1
    for slot in range(n_slots):
        out[at + slot] = slot < robot.heard.n
    at = put_range_bearing(robot, n_slots, out, at + n_slots)
    out[at], out[at + 1] = robot.command.wheels[0], robot.command.wheels[1]
    return at + 2


@inlined
def show_exchange(
    robot: RobotState, crowd: Array, i: int, n_slots: int, out: Float32[Array, " numbers"]
) -> None:
    """Write the observation of a learner of the weighting."""
    put_exchange(crowd[i].exchange, out, 0)


@inlined
def show_situation(
    robot: RobotState, crowd: Array, i: int, n_slots: int, out: Float32[Array, " numbers"]
) -> None:
    """Write the observation of a learner of the motion."""
    put_situation(robot, crowd[i].situation, n_slots, out, 0)


@inlined
def show_both(
    robot: RobotState, crowd: Array, i: int, n_slots: int, out: Float32[Array, " numbers"]
) -> None:
    """Write the observation of a learner of both layers."""
    at = put_exchange(crowd[i].exchange, out, 0)
    put_situation(robot, crowd[i].situation, n_slots, out, at)


@inlined
def show_readings(
    robot: RobotState, crowd: Array, i: int, n_slots: int, out: Float32[Array, " numbers"]
) -> None:
    """Write the observation of a learner of everything: readings, then messages."""
    at = put_sensors(robot, out, 0)
    out[at], out[at + 1] = robot.readings.odometry[0], robot.readings.odometry[1]
    at += 2
    for slot in range(n_slots):
        out[at + slot] = slot < robot.heard.n
    at = put_range_bearing(robot, n_slots, out, at + n_slots)
    for slot in range(n_slots):
        heard = slot < robot.heard.n
        out[at + slot] = robot.heard.n_averaged[slot] if heard else 0
        for k in range(WORDS):
            to = at + n_slots + slot * WORDS + k
            out[to] = crowd[robot.heard.sender[slot]].words[k] if heard else 0.0


@inlined
def put_weights(robot: RobotState, mind: Mind, given: Float32[Array, " numbers"]) -> None:
    """Write the action of a learner of the weighting."""
    robot.action.weight[0], robot.action.weight[1] = given[0], given[1]


@inlined
def put_wheels(robot: RobotState, mind: Mind, given: Float32[Array, " numbers"]) -> None:
    """Write the action of a learner of the motion."""
    robot.action.wheels[0], robot.action.wheels[1] = given[0], given[1]


@inlined
def put_weights_and_wheels(
    robot: RobotState, mind: Mind, given: Float32[Array, " numbers"]
) -> None:
    """Write the action of a learner of both layers."""
    robot.action.weight[0], robot.action.weight[1] = given[0], given[1]
    robot.action.wheels[0], robot.action.wheels[1] = given[2], given[3]


def write_all(
    robots: Array, minds: Array, n_slots: int, out: Float32[Array, "worlds robots numbers"]
) -> None:
    """Write the observations of all robots. Free name: show."""
    for w in range(out.shape[0]):
        for i in range(out.shape[1]):
            show(robots[w, i], minds[w], i, n_slots, out[w, i])


class Said(Record):
    """What a learner of everything says. Writer: the environment."""

    words: Float32[Array, "words"] = field(np.float32, WORDS)
    """The message, whose meaning is the policy's."""

    is_speaking: bool = field(np.bool_)
    """It is broadcast."""


@kernel
def carry_out(robot: RobotState, said: Said) -> None:
    """Command what the policy of a robot that forages says.

    Nobody reports itself lost, and nobody's beliefs are known: a robot that has visited an area
    counts as knowing it.
    """
    robot.command.is_speaking = said.is_speaking
    for k in range(2):
        robot.command.wheels[k] = robot.action.wheels[k]
        robot.report.known[k] = robot.first_visit[k] >= 0


@inlined
def put_everything(robot: RobotState, said: Said, given: Float32[Array, " numbers"]) -> None:
    """Write the action of a learner of everything."""
    robot.action.wheels[0], robot.action.wheels[1] = given[0], given[1]
    said.is_speaking = given[2] > 0.0
    for k in range(WORDS):
        said.words[k] = given[3 + k]


def _weigh(world: Any, controller: Any, learners: Index, action: Array) -> None:  # noqa: ANN401 of its task
    world.robots["action"]["weight"][:, learners] = action


def _move(world: Any, controller: Any, learners: Index, action: Array) -> None:  # noqa: ANN401 of its task
    world.robots["action"]["wheels"][:, learners] = action


def _do_both(world: Any, controller: Any, learners: Index, action: Array) -> None:  # noqa: ANN401 of its task
    _weigh(world, controller, learners, action[:, :, : len(G)])
    _move(world, controller, learners, action[:, :, len(G) :])


def _do_everything(world: Any, controller: Any, learners: Index, action: Array) -> None:  # noqa: ANN401 of its task
    _move(world, controller, learners, action[:, :, :2])
    controller.minds["is_speaking"][:, learners] = action[:, :, 2] > 0.0
    controller.minds["words"][:, learners] = action[:, :, 3:]


@dataclass(frozen=True)
class Writer:
    """Writes observations by an entry point on the records of robots and minds."""

    write: Kernel

    def __call__(self, world: Any, controller: Any, out: Array) -> None:  # noqa: ANN401 of its task
        """Write the observations of all robots."""
        self.write(world.robots, controller.minds["estimator"], world.scenario.slots, out)


_write_readings = bind(write_all, {"show": show_readings})


def _observe_readings(world: Any, controller: Any, out: Array) -> None:  # noqa: ANN401 of its task
    _write_readings(world.robots, controller.minds, world.scenario.slots, out)


def _encounter(bounds: Bounds) -> Groups:
    return {"encounter": encounter_features(bounds)}


def _situation(bounds: Bounds) -> Groups:
    return {"situation": situation_features(bounds, bounds.scenario.slots)}


def _both(bounds: Bounds) -> Groups:
    return {**_encounter(bounds), **_situation(bounds)}


def _raw(bounds: Bounds) -> Groups:
    n_slots = bounds.scenario.slots
    return {"readings": reading_features(bounds), "heard": heard_features(bounds, n_slots)}


STEERINGS = {
    "drive": Steering(
        Layout(
            (
                Feature("drive.speed", "-1 stands, 1 is the cruise speed", *SPEED),
                Feature("drive.turn", "of the sharpest turn, to the left", *SPEED),
            )
        ),
        choices=((1.0, 0.0), (1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)),
        command=drive_to_wheels,
    ),
    "wheels": Steering(
        Layout(SPEEDS),
        choices=((1.0, 1.0), (0.5, 1.0), (1.0, 0.5), (-1.0, 1.0), (1.0, -1.0)),
    ),
}
"""How a policy can steer, by the name that `action` takes; the first is the usual one."""

N_SYMBOLS = 4
"""Messages among which a discrete action of everything chooses, beside silence."""


def symbols() -> Float32[Array, "choices numbers"]:
    """What a robot can say in a discrete action: nothing, or one of the words alone."""
    said = np.zeros((1 + N_SYMBOLS, 1 + WORDS), np.float32)
    said[0, 0], said[1:, 0] = -1.0, 1.0
    said[1:, 1 : 1 + N_SYMBOLS] = np.eye(N_SYMBOLS)
    return said


_INPUTS = {"encounter": WeightingInput, "situation": MotionInput}

LEARNABLE = {
    "weighting": PolicyInterface(
        Layout(G),
        _encounter,
        Writer(bind(write_all, {"show": show_exchange})),
        _weigh,
        ("weighting",),
        _INPUTS,
        PolicyOnGrid(show_exchange, put_weights),
        n_weights=len(G),
    ),
    "motion": PolicyInterface(
        Layout(SPEEDS),
        _situation,
        Writer(bind(write_all, {"show": show_situation})),
        _move,
        ("motion",),
        _INPUTS,
        PolicyOnGrid(show_situation, put_wheels),
        decision_period=10,
        is_steering=True,
        target="situation.target",
    ),
    "both": PolicyInterface(
        Layout(G + SPEEDS),
        _both,
        Writer(bind(write_all, {"show": show_both})),
        _do_both,
        ("weighting", "motion"),
        _INPUTS,
        PolicyOnGrid(show_both, put_weights_and_wheels),
        n_weights=len(G),
        is_steering=True,
        target="situation.target",
    ),
    "everything": PolicyInterface(
        Layout((*SPEEDS, SPEAK, *SAID)),
        _raw,
        _observe_readings,
        _do_everything,
        (),
        {},
        PolicyOnGrid(show_readings, put_everything),
        decision_period=5,
        is_steering=True,
        said=symbols(),
    ),
}
"""What a policy can take the place of, by the name that `learn` takes."""
