"""Compiled weighting rules with the call interface of rules in NumPy."""

import numpy as np

from swarm_forage_env.arrays import Array, Float32
from swarm_forage_env.compiler import bind
from swarm_forage_env.foraging.control import is_weighed as both_know
from swarm_forage_env.interface import Kernel, WeightingLayer
from swarm_forage_env.record import one_record

gain: Kernel
is_weighed: Kernel
"""Free names of the template: the gain of a rule, and whether it weighs an area."""


def weigh_rows(exchanges: Array, numbers: Array, out: Float32[Array, "rows areas"]) -> None:
    """Write the weight of each area that the rule weighs."""
    for i in range(out.shape[0]):
        for area in range(2):
            if exchanges[i].is_valid and is_weighed(exchanges[i], area):
                out[i, area] = gain(exchanges[i], area, numbers[0])


class RowWeighting:
    """Compiled weighting that is called with exchanges, one row per robot."""

    def __init__(self, layer: WeightingLayer, is_weighed: Kernel = both_know) -> None:
        """Bind the functions of a layer and its parameters."""
        self._numbers = one_record(layer.all_numbers)
        self._weigh = bind(weigh_rows, {"gain": layer.gain, "is_weighed": is_weighed})
        self.heard_p_share = layer.heard_p_share

    def __call__(self, exchange: Array) -> Float32[Array, "rows areas"]:
        """Return the weight for each row and area; zero if there is nothing to weigh."""
        g = np.zeros((len(exchange), 2), np.float32)
        self._weigh(exchange, self._numbers, g)
        return g
