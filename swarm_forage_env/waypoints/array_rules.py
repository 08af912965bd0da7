"""Compiled layers on arrays: a hand-written rule that is driven from outside, from observations."""

from collections.abc import Sequence

import numpy as np

from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.compiler import bind
from swarm_forage_env.interface import Kernel, MotionLayer, WeightingLayer
from swarm_forage_env.record import one_record
from swarm_forage_env.waypoints.records import Exchange, Readings, Situation
from swarm_forage_env.waypoints.scenario import WaypointsScenario
from swarm_forage_env.waypoints.views import MotionInput, WeightingInput

gain: Kernel
steer: Kernel
"""Free names of the templates: functions of a layer."""


def weigh_rows(exchanges: Array, numbers: Array, out: Float32[Array, "rows 1"]) -> None:
    """Weigh every correction that is about to be made. Free name: gain."""
    for i in range(out.shape[0]):
        if exchanges[i].is_valid:
            out[i, 0] = gain(exchanges[i], 0, numbers[0])


def steer_rows(
    situations: Array,
    readings: Array,
    memories: Array,
    numbers: Array,
    accelerations: Float32[Array, "rows 2"],
) -> None:
    """Steer every robot; accelerations are the last commands, then the next. Free name: steer."""
    for i in range(accelerations.shape[0]):
        steer(situations[i], readings[i], accelerations[i], memories[i], numbers[0])


class ArrayWeighting:
    """A compiled weighting that is called with what the weighting layer sees."""

    def __init__(self, layer: WeightingLayer) -> None:
        """A layer with its numbers."""
        self._numbers = one_record(layer.all_numbers)
        self._weigh = bind(weigh_rows, {"gain": layer.gain})
        self.heard_p_share = layer.heard_p_share

    def __call__(self, exchange: WeightingInput) -> Float32[Array, "rows 1"]:
        """The weight of each row; zero where there is no correction."""
        found = Exchange.array(exchange.valid.shape)
        found["is_valid"], found["neighbours"] = exchange.valid, exchange.neighbours
        found["own_covariance_norm"] = exchange.own_doubt
        found["heard_covariance_norm"] = exchange.heard_doubt
        found["disagreement"] = exchange.disagreement
        g = np.zeros((len(found), 1), np.float32)
        self._weigh(found, self._numbers, g)
        return g


class ArrayMotion:
    """A compiled motion that is called with what the motion layer sees, and remembers."""

    def __init__(
        self, layer: MotionLayer, scenario: WaypointsScenario, seeds: Sequence[int]
    ) -> None:
        """The motion of a block of worlds, one for each seed."""
        self._layer, self._n_robots = layer, scenario.task.n_robots
        self._numbers = one_record(layer.numbers)
        self._steer = bind(steer_rows, {"steer": layer.steer})
        self._memory = layer.memory.array((len(seeds), self._n_robots))

    def __call__(self, situation: MotionInput) -> Float32[Array, "rows 2"]:
        """Acceleration ahead and to the left, as a share of the highest."""
        n_rows = len(situation.density)
        believed = Situation.array((n_rows,))
        for name in ("goal", "home", "centre", "velocity", "density"):
            believed[name] = getattr(situation, name)
        believed["separation"], believed["alignment"] = situation.crowd, situation.flow
        believed["covariance_norm"] = situation.doubt
        believed["dead_reckoning_offset"] = situation.drift
        believed["has_arrived"] = situation.arrived
        pull: Float32[Array, "rows 2"] = situation.pull.copy()
        readings = Readings.array((n_rows,))
        self._steer(believed, readings, self._memory.reshape(-1), self._numbers, pull)
        return pull

    def reset(self, world: int, seed: int) -> None:
        """Forget everything about one world."""
        self._layer.memory.restart(self._memory[world])
