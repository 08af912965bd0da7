"""The control of patrol: two templates, a layer of each kind, and a controller that has them."""

from typing import ClassVar

import numpy as np
from pydantic import Field

from baselines.composition import no_gain
from baselines.controller import LayeredController
from baselines.estimators import ESTIMATORS
from baselines.motion import MOTIONS
from baselines.weighting import WEIGHTING_RULES
from swarm_forage_env.compiler import kernel
from swarm_forage_env.interface import KEEP, EstimatorLayer, MotionLayer, WeightingLayer
from swarm_forage_env.parameters import Part, Positive, Share
from swarm_forage_env.record import Record, field
from swarm_forage_env.registry import CONTROLLERS

SCALE = 5.0
"""Usual distance to a place [m]."""


class Situation(Record):
    """What a robot believes: where the next place is, body frame."""

    place = field(np.float32, 2, unit="m", scale=SCALE, names=("xy",))


class Mind(Record):
    """All that the estimator keeps of a robot."""

    situation = field(Situation)


def observe(robots, minds, shared, settings, first, last):
    """Take in what was sensed. Free name: take_in."""
    for w in range(first, last):
        for i in range(robots.shape[1]):
            if settings[w, i].is_member:
                take_in(minds[w, i], robots[w, i].readings, settings[w, i].estimator)


def decide(robots, minds, shared, layers, first, last):
    """Steer, or do as the action says. Free name: steer."""
    for w in range(first, last):
        for i in range(robots.shape[1]):
            if not layers[w, i].is_member:
                continue
            mind, action = minds[w, i], robots[w, i].action
            readings, wheels = robots[w, i].readings, robots[w, i].command.wheels
            if action.motion == KEEP:
                situation = mind.estimator.situation
                steer(situation, readings, wheels, mind.motion, layers[w, i].motion)
            else:
                wheels[0], wheels[1] = action.wheels[0], action.wheels[1]


@kernel
def take_in(mind, readings, numbers):
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
class Mean(Part):
    """The next place as a running mean. Source: textbook (exponential smoothing)."""

    tasks: ClassVar[tuple[str, ...]] = ("patrol",)
    speaks: ClassVar[bool] = False

    share: Share = Field(0.5, description="Of a new reading in the mean (chosen)")

    def layer(self, scenario):
        return EstimatorLayer(Mind, {"share": self.share}, {"take_in": take_in}, observe)


@WEIGHTING_RULES.register("patrol_alone")
class Alone(Part):
    """Robots on patrol tell each other nothing. Source: none needed."""

    tasks: ClassVar[tuple[str, ...]] = ("patrol",)

    def layer(self, scenario):
        return WeightingLayer(no_gain)


@MOTIONS.register("patrol_ahead")
class Ahead(Part):
    """Straight to the next place. Source: textbook (proportional control)."""

    tasks: ClassVar[tuple[str, ...]] = ("patrol",)

    turn: Positive = Field(1.0, description="Turn for a place at the side (chosen)")

    def layer(self, scenario):
        return MotionLayer(steer, {"turn": self.turn})


PATROL = LayeredController("patrol-ahead", Mean(), Alone(), Ahead())
CONTROLLERS.register(PATROL.name)(PATROL)
