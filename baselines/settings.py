"""What the compiled halves of a tick read of each robot: whether it is theirs, and its numbers."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from swarm_forage_env.arrays import Array, Bool
from swarm_forage_env.interface import EstimatorLayer, KernelNumbers, MotionLayer, WeightingLayer
from swarm_forage_env.record import numbers_record, record_dtype
from swarm_forage_env.task import consecutive

Layers = tuple[EstimatorLayer, WeightingLayer, MotionLayer]

LAYERS = ("estimator", "weighting", "motion")

Crew = Sequence[Sequence[Any]]
"""The layers of every robot of every world, None for a robot of another estimator. Robots of one
controller have the same object."""

Members = Bool[Array, " robots"]
"""Which robots of a world are meant."""


def settings_of(crew: Crew, parts: Sequence[str], members: Members, is_last: bool = False) -> Array:
    """A record for each robot of each world: is it a member, and the numbers of these layers.

    Of a robot that is none only the estimator's numbers are written. `is_last` tells that no
    other robots of the same estimator are decided after these.

    Robots that all have the same numbers share one column.
    """
    n_worlds, n_robots = len(crew), len(members)
    some = crew[0][int(np.argmax(members))]
    kinds = [(part, numbers_record(**numbers)) for part, numbers in _numbers_of(some, parts)]
    dtype = record_dtype([("is_member", np.bool_), ("is_last", np.bool_), *kinds])
    different = list({id(row): row for row in crew}.values())
    is_shared = all(layers is row[0] for row in different for layers in row)
    n_columns = 1 if is_shared else n_robots
    settings = np.zeros((n_worlds, n_columns), dtype)
    settings["is_member"], settings["is_last"] = members[:n_columns], is_last
    for first, last in consecutive(range(n_worlds), crew):
        _write(settings[first:last], crew[first][:n_columns], parts, members[:n_columns])
    return settings


def _write(out: Array, row: Sequence[Any], parts: Sequence[str], members: Members) -> None:
    """Write the numbers of every robot of worlds with the same layers."""
    for layers in {id(each): each for each in row if each is not None}.values():
        whose = np.array([each is layers for each in row])
        for part, numbers in _numbers_of(layers, parts):
            to = whose if part == "estimator" else whose & members
            for name, value in numbers.items() if to.any() else ():
                out[part][name][:, to] = value


def _numbers_of(layers: Layers, parts: Sequence[str]) -> Iterator[tuple[str, KernelNumbers]]:
    """The numbers of each of these layers."""
    estimator, weighting, motion = layers
    every = estimator.numbers, weighting.all_numbers, motion.numbers
    return ((part, numbers) for part, numbers in zip(LAYERS, every, strict=True) if part in parts)
