"""What policies in the foraging world are shown and do: functions of one robot, for CPU and GPU."""

from typing import Any

import numpy as np

from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.compiler import inlined, kernel
from swarm_forage_env.foraging.observations import WORDS
from swarm_forage_env.foraging.records import Exchange, RobotState, Situation
from swarm_forage_env.interface import Kernel
from swarm_forage_env.record import Record, field

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
