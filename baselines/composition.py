"""Composition of the robots of a block of worlds: layers, numbers, and groups with the same."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from baselines.weighting.base import no_gain
from swarm_forage_env.arrays import Array, Bool
from swarm_forage_env.compiler import kernel
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.interface import EstimatorLayer, KernelNumbers, MotionLayer, WeightingLayer
from swarm_forage_env.parameters import BaseScenario
from swarm_forage_env.record import Rows, numbers_record, record_dtype
from swarm_forage_env.task import consecutive

Layer = EstimatorLayer | WeightingLayer | MotionLayer
Layers = tuple[EstimatorLayer, WeightingLayer, MotionLayer]

LAYERS = ("estimator", "weighting", "motion")


@dataclass(frozen=True)
class LayerParts:
    """The parameters of the three layers of a controller.

    A layer is compiled if its parameters have a method `layer` that does not return None. Otherwise
    it is a rule in NumPy: a weighting is called, a motion is what its method `start` returns.
    """

    name: str
    estimator: Any
    weighting: Any
    motion: Any


Row = Sequence[Any]
"""The controllers, or their layers, of the robots of a world; None for a robot of another team.
Robots of one controller have the same object."""

Composition = list[tuple[list[object], object]]
"""What each layer of a controller consists of, except numbers; or its rule in NumPy."""

Members = Bool[Array, " robots"]  # a mask of the robots of a world


def settings_of(
    robot_layers: Sequence[Row], parts: Sequence[str], members: Members, is_last: bool = False
) -> Array:
    """A record for each robot of each world: its membership, and the parameters of these layers.

    For non-members only the estimator's parameters are written. `is_last`: no other robots of the
    same estimator are decided after these. Robots with equal parameters share one column.
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
    estimator, weighting, motion = layers
    every = estimator.numbers, weighting.all_numbers, motion.numbers
    return ((part, numbers) for part, numbers in zip(LAYERS, every, strict=True) if part in parts)


def layers_by_robot(controllers: Sequence[Row], scenarios: Sequence[BaseScenario]) -> Sequence[Row]:
    """The layers of every robot; worlds of the same controllers and scenario share one row."""
    made: dict[tuple[int, ...], Row] = {}
    robot_layers = []
    for row, scenario in zip(controllers, scenarios, strict=True):
        key = id(scenario), *map(id, row)
        if key not in made:
            different = {id(each): each for each in row if each is not None}
            layers = {each: layers_of(own, scenario) for each, own in different.items()}
            made[key] = [layers.get(id(each)) for each in row]
        robot_layers.append(made[key])
    return robot_layers


def groups_of(controllers: Row, layers: Row) -> list[Members]:
    """Group the robots of a world by the functions of their layers."""
    compositions: dict[int, Composition] = {}
    for controller, own in zip(controllers, layers, strict=True):
        if own is not None and id(own) not in compositions:
            compositions[id(own)] = composition_of(controller, own)
    different: list[Composition] = []
    for each in compositions.values():
        if each not in different:
            different.append(each)
    return [
        np.array([compositions.get(id(own)) == composition for own in layers])
        for composition in different
    ]


def check_alike(controllers: Sequence[Row], robot_layers: Sequence[Row]) -> None:
    """ConfigError if the controllers of a robot differ between worlds in more than numbers."""
    checked = set()
    different = {
        id(layers): (row, layers) for row, layers in zip(controllers, robot_layers, strict=True)
    }
    for row, layers in different.values():
        for one, other, mine, his in zip(controllers[0], row, robot_layers[0], layers, strict=True):
            if (id(mine), id(his)) in checked or mine is None:
                continue
            checked.add((id(mine), id(his)))
            compositions = composition_of(one, mine), composition_of(other, his)
            for name, first, layer in zip(LAYERS, *compositions, strict=True):
                if first != layer:
                    raise ConfigError(
                        f"controllers '{one.name}' and '{other.name}' have another {name}: those"
                        " of one block may differ in their numbers only"
                    )


def composition_of(controller: LayerParts, layers: Layers) -> Composition:
    """What each layer of a controller consists of, except numbers; or its rule in NumPy."""
    estimator, weighting, motion = layers
    is_compiled = hasattr(controller.weighting, "layer")
    return [
        (functions_of(estimator), None),
        (functions_of(weighting), None if is_compiled else controller.weighting),
        (functions_of(motion), controller.motion if motion.steer is no_motion else None),
    ]


def functions_of(layer: Layer) -> list[object]:
    """What a layer consists of, and of its numbers the names and shapes."""
    numbers = ("numbers", "heard_p_share", "own_weighting")
    functions = [getattr(layer, each.name) for each in fields(layer) if each.name not in numbers]
    return [*functions, sorted((name, np.shape(value)) for name, value in layer.numbers.items())]


@kernel
def no_motion(*seen: object) -> None:
    """Leave the command: that of a rule written in NumPy comes as an action."""


@kernel
def set_stream(memory: Rows, word: np.uint64) -> None:
    """Set the stream of a motion's memory to its start."""
    memory.stream[0] = word


def layers_of(controller: LayerParts, scenario: BaseScenario) -> Layers:
    """The three layers of a controller in a scenario."""
    estimator = controller.estimator.layer(scenario)
    estimator.check_falsifiable(controller.name, scenario)
    rule, part = controller.weighting, controller.motion
    if hasattr(rule, "layer"):
        weighting = rule.layer(scenario) or estimator.own_weighting
    else:
        weighting = WeightingLayer(no_gain, heard_p_share=rule.heard_p_share)
    if weighting is None:
        raise ConfigError("weighting 'filter': this estimator has no gain of its own; name a rule")
    motion = part.layer(scenario) if hasattr(part, "layer") else None
    return estimator, weighting, motion or MotionLayer(no_motion, {})
