"""Compiled layers on arrays: a hand-written rule that is driven from outside, from observations."""

from collections.abc import Sequence

import numpy as np

from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.compiler import bind
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.foraging.control import is_weighed
from swarm_forage_env.foraging.records import Exchange, Heard, Readings, Situation
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.foraging.views import MotionInput, WeightingInput
from swarm_forage_env.interface import Kernel, MotionLayer, WeightingLayer
from swarm_forage_env.random_streams import streams
from swarm_forage_env.record import Record, one_record, record_dtype

gain: Kernel
steer: Kernel
"""Free names of the templates: functions of a layer."""


def weigh_rows(exchanges: Array, numbers: Array, out: Float32[Array, "rows areas"]) -> None:
    """Weigh what was heard of every area that both robots know. Free name: gain."""
    for i in range(out.shape[0]):
        for area in range(2):
            if exchanges[i].is_valid and is_weighed(exchanges[i], area):
                out[i, area] = gain(exchanges[i], area, numbers[0])


def steer_rows(
    situations: Array, readings: Array, heard: Array, memories: Array, numbers: Array,
    wheels: Float32[Array, "rows 2"],
) -> None:  # fmt: skip
    """Steer every robot; `wheels` are the last commands, and then the next. Free name: steer."""
    for i in range(wheels.shape[0]):
        steer(situations[i], readings[i], heard[i], wheels[i], memories[i], numbers[0])


class ArrayWeighting:
    """A compiled weighting that is called with what the weighting layer sees."""

    def __init__(self, layer: WeightingLayer) -> None:
        """A layer with its numbers."""
        self._numbers = one_record(layer.all_numbers)
        self._weigh = bind(weigh_rows, {"gain": layer.gain})
        self.heard_p_share = layer.heard_p_share

    def __call__(self, exchange: WeightingInput) -> Float32[Array, "rows areas"]:
        """The weight of each row and area; zero where there is nothing to weigh."""
        found = Exchange.array(exchange.valid.shape)
        found["is_valid"], found["n_averaged"] = exchange.valid, exchange.frames
        for name in found.dtype.names or ():
            if hasattr(exchange, name):
                found[name] = getattr(exchange, name)
        g = np.zeros((len(found), 2), np.float32)
        self._weigh(found, self._numbers, g)
        return g


class ArrayMotion:
    """A compiled motion that is called with what the motion layer sees, and remembers."""

    def __init__(self, layer: MotionLayer, scenario: Scenario, seeds: Sequence[int]) -> None:
        """The motion of a block of worlds, one for each seed.

        ConfigError if it goes by a field that is not shown from outside.
        """
        self._layer, self._n_robots = layer, scenario.task.n_robots
        self._numbers = one_record(layer.numbers)
        self._steer = bind(steer_rows, {"steer": layer.steer})
        self._memory = layer.memory.array((len(seeds), self._n_robots))
        for world, seed in enumerate(seeds):
            self.reset(world, seed)
        try:
            self._run(*_records(0, scenario.slots), np.zeros((0, 2), np.float32))
        except KeyError as field:  # numba's, of a record without it
            raise ConfigError(
                f"motion: goes by {field}, which MotionInput does not show, so that it cannot"
                " be driven from outside; run it in a Loop, or show it in foraging/views.py"
            ) from None

    def __call__(self, situation: MotionInput) -> Float32[Array, "rows 2"]:
        """Speed of the left and right wheel, in [-1, 1] of the cruise speed."""
        n_rows, n_slots = situation.heard.shape
        believed, readings, heard = _records(n_rows, n_slots)
        for name in ("target", "areas", "p", "known", "goal"):
            believed[name] = getattr(situation, name)
        believed["is_talking"] = situation.talking
        readings["proximity"], readings["ground"] = situation.proximity, situation.ground
        heard["n"], heard["range_bearing"] = situation.heard.sum(axis=1), situation.beam
        wheels: Float32[Array, "rows 2"] = situation.wheels.copy()
        self._run(believed, readings, heard, wheels)
        return wheels

    def _run(self, believed: Array, readings: Array, heard: Array, wheels: Array) -> None:
        memories = self._memory.reshape(-1)
        self._steer(believed, readings, heard, memories, self._numbers, wheels)

    def reset(self, world: int, seed: int) -> None:
        """Forget everything about one world, and draw from this seed from now on."""
        memory = self._memory[world]
        self._layer.memory.restart(memory)
        if "stream" in self._layer.memory.fields:
            memory["stream"][:, 0] = streams([seed], self._n_robots, self._layer.noise)


def _records(n_rows: int, n_slots: int) -> tuple[Array, Array, Array]:
    """Records of situations, readings and messages that have no field but those that are shown."""
    situation = "target", "areas", "p", "known", "goal", "is_talking"
    return (
        _only(Situation, situation, n_rows),
        _only(Readings, ("proximity", "ground"), n_rows),
        _only(Heard, ("n", "range_bearing"), n_rows, slots=n_slots),
    )


def _only(record: type[Record], names: Sequence[str], n_rows: int, **sizes: int) -> Array:
    dtype = record.dtype(**sizes)
    return np.zeros(n_rows, record_dtype([(name, dtype[name]) for name in names]))
