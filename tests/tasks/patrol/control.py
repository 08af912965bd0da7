"""The control of patrol: row templates, a layer of each kind, and a controller that has them."""

from typing import ClassVar

import numpy as np
from pydantic import Field

from baselines.controller import LayeredController
from baselines.estimators import ESTIMATORS
from baselines.motion import MOTIONS
from baselines.weighting import WEIGHTING_RULES
from baselines.weighting.base import no_gain
from swarm_forage_env.compiler import kernel
from swarm_forage_env.interface import KEEP, EstimatorLayer, MotionLayer, WeightingLayer
from swarm_forage_env.parameters import Parameters, Positive, Share
from swarm_forage_env.record import Record, field
from swarm_forage_env.registry import CONTROLLERS
from swarm_forage_env.templates import row_template

SCALE = 5.0
"""Usual distance to a place [m]."""


class Situation(Record):
    """What a robot believes: where the next place is, body frame."""

    place = field(np.float32, 2, unit="m", scale=SCALE, names=("xy",))


class Mind(Record):
    """All that the estimator keeps of a robot."""

    situation = field(Situation)


@row_template
def observe_world(world_arrays, layer_arrays, w, n_robots):
    """Take in what was sensed. Free name: update_belief."""
    robots, (minds, _, _, settings) = world_arrays[0], layer_arrays
    for i in range(n_robots):
        own = settings[w, min(i, settings.shape[1] - 1)]
        if own.is_member:
            update_belief(minds[w, i], robots[w, i].readings, own.estimator)


@row_template
def decide_world(world_arrays, layer_arrays, errors, w, n_robots):
    """Steer, or do as the action says. Free name: steer."""
    robots, (minds, memories, _, settings) = world_arrays[0], layer_arrays
    for i in range(n_robots):
        own, robot = settings[w, min(i, settings.shape[1] - 1)], robots[w, i]
        wheels = robot.command.wheels
        if own.is_member and robot.action.motion == KEEP:
            steer(minds[w, i].situation, robot.readings, wheels, memories[w, i], own.motion)
        elif own.is_member:
            wheels[0], wheels[1] = robot.action.wheels[0], robot.action.wheels[1]


@kernel
def update_belief(mind, readings, numbers):
    """A running mean of what is sensed."""
    for k in range(2):
        place = mind.situation.place
        place[k] += numbers.share * (readings.place[k] - place[k])


@kernel
def steer(situation, readings, wheels, memory, numbers):
    """Turn to the place, and go on while turning."""
    place = situation.place
    turn = numbers.turn * place[1] / (abs(place[0]) + abs(place[1]) + 1e-6)
    if place[0] < 0.0:
        turn = 1.0
    wheels[0] = min(max(1.0 - turn, -1.0), 1.0)
    wheels[1] = min(max(1.0 + turn, -1.0), 1.0)


@ESTIMATORS.register("patrol_mean")
class Mean(Parameters):
    """The next place as a running mean. Source: textbook (exponential smoothing)."""

    tasks: ClassVar[tuple[str, ...]] = ("patrol",)
    speaks: ClassVar[bool] = False

    share: Share = Field(0.5, description="Share of a new reading in the mean (chosen)")

    def layer(self, scenario):
        return EstimatorLayer(
            Mind, {"share": self.share}, {"update_belief": update_belief}, observe_world
        )


@WEIGHTING_RULES.register("patrol_alone")
class Alone(Parameters):
    """Robots on patrol tell each other nothing. Source: none needed."""

    tasks: ClassVar[tuple[str, ...]] = ("patrol",)

    def layer(self, scenario):
        return WeightingLayer(no_gain)


@MOTIONS.register("patrol_ahead")
class Ahead(Parameters):
    """Straight to the next place. Source: textbook (proportional control)."""

    tasks: ClassVar[tuple[str, ...]] = ("patrol",)

    turn: Positive = Field(1.0, description="Turn for a place at the side (chosen)")

    def layer(self, scenario):
        return MotionLayer(steer, {"turn": self.turn})


PATROL = LayeredController("patrol-ahead", Mean(), Alone(), Ahead())
CONTROLLERS.register(PATROL.name)(PATROL)
