"""Composition of the robots of a block: layers, parameters, and groups with equal functions."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from swarm_forage_env.arrays import Array, Bool
from swarm_forage_env.compiler import kernel
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.interface import EstimatorLayer, KernelNumbers, MotionLayer, WeightingLayer
from swarm_forage_env.parameters import BaseScenario
from swarm_forage_env.record import Rows, numbers_record, record_dtype
from swarm_forage_env.task import consecutive

LAYERS = ("estimator", "weighting", "motion")


@dataclass(frozen=True)
class Layers:
    """The three layers of a controller in a scenario."""

    name: str  # name of the controller
    estimator: EstimatorLayer
    weighting: WeightingLayer
    motion: MotionLayer
    weighting_rule: Any = None
    """Weighting rule in NumPy: a callable; None if the weighting is compiled."""
    motion_rule: Any = None
    """Parameters whose method `start` returns a motion rule in NumPy; None if it is compiled."""

    @property
    def composition(self) -> list[object]:
        """Functions of each layer, without parameter values, and its rule in NumPy if any."""
        return [
            functions_of(self.estimator),
            (functions_of(self.weighting), self.weighting_rule),
            (functions_of(self.motion), self.motion_rule),
        ]


Row = Sequence[Any]
"""Controller, or layers, of each robot of a world; None for robots of other teams. Robots with the
same controller share one object."""

Members = Bool[Array, " robots"]  # a mask of the robots of a world


def settings_of(
    robot_layers: Sequence[Row], parts: Sequence[str], members: Members, is_last: bool = False
) -> Array:
    """Return a record for each robot of each world: membership, and the parameters of these layers.

    Non-members have parameters of the estimator only. `is_last`: no other robots with the same
    estimator decide after these. If all robots of each world share one object, there is one column.
    """
    n_worlds, n_robots = len(robot_layers), len(members)
    some = robot_layers[0][int(np.argmax(members))]
    kinds = [(part, numbers_record(**numbers)) for part, numbers in _numbers_of(some, parts)]
    dtype = record_dtype([("is_member", np.bool_), ("is_last", np.bool_), *kinds])
    different = list({id(row): row for row in robot_layers}.values())
    is_shared = all(layers is row[0] for row in different for layers in row)
    n_columns = 1 if is_shared else n_robots
    settings = np.zeros((n_worlds, n_columns), dtype)
    settings["is_member"], settings["is_last"] = members[:n_columns], is_last
    for first, last in consecutive(range(n_worlds), robot_layers):
        _write(settings[first:last], robot_layers[first][:n_columns], parts, members[:n_columns])
    return settings


def _write(out: Array, row: Row, parts: Sequence[str], members: Members) -> None:
    for layers in {id(each): each for each in row if each is not None}.values():
        whose = np.array([each is layers for each in row])
        for part, numbers in _numbers_of(layers, parts):
            to = whose if part == "estimator" else whose & members
            for name, value in numbers.items() if to.any() else ():
                out[part][name][:, to] = value


def _numbers_of(layers: Layers, parts: Sequence[str]) -> Iterator[tuple[str, KernelNumbers]]:
    every = layers.estimator.numbers, layers.weighting.all_numbers, layers.motion.numbers
    return ((part, numbers) for part, numbers in zip(LAYERS, every, strict=True) if part in parts)


def layers_by_robot(controllers: Sequence[Row], scenarios: Sequence[BaseScenario]) -> Sequence[Row]:
    """Return the layers of each robot; worlds with equal controllers and scenario share one row."""
    made: dict[tuple[int, ...], Row] = {}
    robot_layers = []
    for row, scenario in zip(controllers, scenarios, strict=True):
        key = id(scenario), *map(id, row)
        if key not in made:
            different = {id(each): each for each in row if each is not None}
            layers = {each: own.layers_in(scenario) for each, own in different.items()}
            made[key] = [layers.get(id(each)) for each in row]
        robot_layers.append(made[key])
    return robot_layers


def groups_of(row: Row) -> list[Members]:
    """Group the robots of a world by the functions of their layers."""
    compositions = {id(each): each.composition for each in row if each is not None}
    different: list[list[object]] = []
    for each in compositions.values():
        if each not in different:
            different.append(each)
    return [
        np.array([compositions.get(id(own)) == composition for own in row])
        for composition in different
    ]


def check_alike(robot_layers: Sequence[Row]) -> None:
    """Raise ConfigError if the controllers of a robot differ between worlds in their functions."""
    pairs = {
        (id(one), id(other)): (one, other)
        for row in {id(row): row for row in robot_layers}.values()
        for one, other in zip(robot_layers[0], row, strict=True)
        if one is not None
    }
    for one, other in pairs.values():
        for name, mine, his in zip(LAYERS, one.composition, other.composition, strict=True):
            if mine != his:
                raise ConfigError(
                    f"controllers '{one.name}' and '{other.name}' differ in their {name}: the"
                    " controllers of one block may differ in parameters only"
                )


def functions_of(layer: EstimatorLayer | WeightingLayer | MotionLayer) -> list[object]:
    """Return the functions of a layer, and names and shapes of its parameters."""
    numbers = ("numbers", "heard_p_share", "own_weighting")
    functions = [getattr(layer, each.name) for each in fields(layer) if each.name not in numbers]
    return [*functions, sorted((name, np.shape(value)) for name, value in layer.numbers.items())]


@kernel
def no_motion(*seen: object) -> None:
    """Leave the command unchanged: a rule written in NumPy writes an action instead."""


@kernel
def set_stream(memory: Rows, word: np.uint64) -> None:
    """Write the first word of the random stream to the memory of a motion."""
    memory.stream[0] = word
