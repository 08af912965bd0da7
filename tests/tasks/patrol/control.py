"""The control of patrol: two templates, a layer of each kind, and a controller that has them."""

from typing import ClassVar

import numpy as np
from pydantic import Field

from baselines.composition import no_gain
from baselines.controller import LayeredController
from baselines.estimators import ESTIMATORS
from baselines.motion import MOTIONS
from baselines.weighting import WEIGHTING_RULES
from swarm_forage_env.compiler import bind, kernel
from swarm_forage_env.interface import KEEP, EstimatorLayer, MotionLayer, WeightingLayer
from swarm_forage_env.parameters import Part, Positive, Share
from swarm_forage_env.record import Record, field, one_record
from swarm_forage_env.registry import CONTROLLERS


class Mind(Record):
    """What a robot believes: where the next place is, body frame."""

    place = field(np.float32, 2, unit="m")


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
            action, wheels = robots[w, i].action, robots[w, i].command.wheels
            if action.motion == KEEP:
                steer(minds[w, i].estimator, wheels, layers[w, i].motion)
            else:
                wheels[0], wheels[1] = action.wheels[0], action.wheels[1]


def steer_rows(minds, numbers, wheels):
    """Steer every robot. Free name: steer."""
    for i in range(wheels.shape[0]):
        steer(minds[i], wheels[i], numbers[0])


@kernel
def take_in(mind, readings, numbers):
    """A running mean of what is sensed."""
    for k in range(2):
        mind.place[k] += numbers.share * (readings.place[k] - mind.place[k])


@kernel
def steer(mind, wheels, numbers):
    """Turn to the place, and go on while turning."""
    turn = numbers.turn * mind.place[1] / (abs(mind.place[0]) + abs(mind.place[1]) + 1e-6)
    if mind.place[0] < 0.0:
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


class ArrayMotion:
    """A compiled motion that is called with what the motion layer sees."""

    def __init__(self, layer, scenario, seeds):
        self._numbers = one_record(layer.numbers)
        self._steer = bind(steer_rows, {"steer": layer.steer})

    def __call__(self, situation):
        minds = Mind.array((len(situation.place),))
        minds["place"], wheels = situation.place, np.zeros_like(situation.place)
        self._steer(minds, self._numbers, wheels)
        return wheels


PATROL = LayeredController("patrol-ahead", Mean(), Alone(), Ahead())
CONTROLLERS.register(PATROL.name)(PATROL)
