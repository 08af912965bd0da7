"""What the robots of a block of worlds are made of: their layers, the numbers, who has the same."""

from collections.abc import Iterator, Sequence
from dataclasses import fields
from typing import Any, cast

import numpy as np

from baselines.weighting.base import no_gain
from swarm_forage_env.arrays import Array, Bool
from swarm_forage_env.compiler import kernel
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.foraging.control import observe_world
from swarm_forage_env.interface import EstimatorLayer, KernelNumbers, MotionLayer, WeightingLayer
from swarm_forage_env.parameters import Part
from swarm_forage_env.record import numbers_record, record_dtype
from swarm_forage_env.task import consecutive
from swarm_forage_env.ticks import nothing

Layer = EstimatorLayer | WeightingLayer | MotionLayer
Layers = tuple[EstimatorLayer, WeightingLayer, MotionLayer]

LAYERS = ("estimator", "weighting", "motion")

Row = Sequence[Any]
"""The controllers, or their layers, of the robots of a world; None for a robot of another team.
Robots of one controller have the same object."""

Composition = list[tuple[list[object], object]]
"""What each layer of a controller consists of, but for its numbers; or its rule in NumPy."""

Members = Bool[Array, " robots"]
"""Which robots of a world are meant."""


def settings_of(
    robot_layers: Sequence[Row], parts: Sequence[str], members: Members, is_last: bool = False
) -> Array:
    """A record for each robot of each world: is it a member, and the parameters of these layers.

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
    """Write the numbers of every robot of worlds with the same layers."""
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


def layers_by_robot(controllers: Sequence[Row], scenarios: Sequence[Part]) -> Sequence[Row]:
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
    """Which robots of a world have layers of the same functions."""
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
    """ConfigError if the controllers of a robot differ from world to world but in numbers."""
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


def check_on_gpu(name: str, estimator: EstimatorLayer, has_rules: bool, n_groups: int) -> None:
    """ConfigError for a controller that runs on a CPU only, with the reason."""
    reasons = {
        "a layer of it is a rule in NumPy": has_rules,
        "its robots have several compositions": n_groups > 1,
        "its estimator keeps something of each pair of robots": estimator.shared is not None,
        "its estimator takes in with a template of its own": estimator.observe
        not in (observe_world, nothing),
    }
    for reason, holds in reasons.items():
        if holds:
            raise ConfigError(
                f"device='cuda': controller '{name}' runs on a CPU only, as {reason}; take"
                " another one, as ssgikf, or device='cpu'"
            )


def composition_of(controller: Any, layers: Layers) -> Composition:  # noqa: ANN401 layered
    """What each layer of a controller consists of, but for its numbers; or its rule in NumPy."""
    found, own = [], cast("tuple[Layer, ...]", layers)
    for name, layer in zip(LAYERS, own, strict=True):
        part = getattr(controller, name)
        is_rule = not hasattr(part, "layer") or is_numpy_motion(layer)
        found.append((functions_of(layer), part if is_rule else None))
    return found


def is_numpy_motion(layer: Layer) -> bool:
    """Whether a layer leaves the motion to a rule in NumPy."""
    return isinstance(layer, MotionLayer) and layer.steer is no_motion


def functions_of(layer: Layer) -> list[object]:
    """What a layer consists of, but for its numbers: their names and shapes."""
    numbers = ("numbers", "heard_p_share", "own_weighting")
    kept = [getattr(layer, each.name) for each in fields(layer) if each.name not in numbers]
    return [*kept, sorted((name, np.shape(value)) for name, value in layer.numbers.items())]


@kernel
def no_motion(*seen: object) -> None:
    """The command stays as it is: that of a rule written in NumPy comes as an action."""


@kernel
def set_stream(memory: Any, word: np.uint64) -> None:  # noqa: ANN401 of any motion
    """Put the stream of a motion's memory at its start."""
    memory.stream[0] = word


def layers_of(controller: Any, scenario: Part) -> Layers:  # noqa: ANN401 layered
    """The three layers of a controller in a scenario."""
    estimator = controller.estimator.layer(scenario)
    estimator.check_falsifiable(controller.name, scenario)
    weighting = _weighting_layer(controller.weighting, scenario, estimator)
    return estimator, weighting, _motion_layer(controller.motion, scenario)


def _weighting_layer(part: Any, scenario: Part, estimator: EstimatorLayer) -> WeightingLayer:  # noqa: ANN401
    if not hasattr(part, "layer"):
        return WeightingLayer(no_gain, heard_p_share=part.heard_p_share)
    layer: WeightingLayer | None = part.layer(scenario) or estimator.own_weighting
    if layer is None:
        raise ConfigError("weighting 'filter': this estimator has no gain of its own; name a rule")
    return layer


def _motion_layer(part: Any, scenario: Part) -> MotionLayer:  # noqa: ANN401 compiled or not
    layer: MotionLayer | None = part.layer(scenario) if hasattr(part, "layer") else None
    return layer or MotionLayer(no_motion, {})
