"""Layers of several controllers as one: in every stage of a tick they run one after the other."""

from collections.abc import Mapping, Sequence
from functools import reduce

from swarm_forage_env.arrays import Array, Int64
from swarm_forage_env.compiler import bind_row
from swarm_forage_env.interface import CompiledLayers, Kernel
from swarm_forage_env.templates import is_row_template, row_template
from swarm_forage_env.ticks import Arrays

decide_before: Kernel
decide_after: Kernel
observe_before: Kernel
observe_after: Kernel
"""Free names of the templates."""


@row_template
def decide_both(
    world_arrays: Arrays,
    layer_arrays: Arrays,
    trouble: Int64[Array, " worlds_and_one"],
    w: int,
    n_robots: int,
) -> None:
    """Decide by two sets of layers in a world. Free names: decide_before, decide_after."""
    decide_before(world_arrays, layer_arrays[0], trouble, w, n_robots)
    decide_after(world_arrays, layer_arrays[1], trouble, w, n_robots)


@row_template
def observe_both(world_arrays: Arrays, layer_arrays: Arrays, w: int, n_robots: int) -> None:
    """Observe by two sets of layers in a world. Free names: observe_before, observe_after."""
    observe_before(world_arrays, layer_arrays[0], w, n_robots)
    observe_after(world_arrays, layer_arrays[1], w, n_robots)


def joined(layers: Sequence[CompiledLayers]) -> CompiledLayers:
    """Several sets of layers, each of its own robots, for one call on a CPU."""
    return reduce(_both, layers)


def _bound(function: Kernel, functions: Mapping[str, Kernel]) -> Kernel:
    """A row template with its functions; what has no free names as it is."""
    return bind_row(function, functions) if is_row_template(function) else function


def _both(before: CompiledLayers, after: CompiledLayers) -> CompiledLayers:
    functions = {}
    for stage, template in (("decide", decide_both), ("observe", observe_both)):
        each = {
            f"{stage}_{order}": _bound(layers.functions[f"{stage}_world"], layers.functions)
            for order, layers in (("before", before), ("after", after))
        }
        functions[f"{stage}_world"] = bind_row(template, each)
    return CompiledLayers(functions, (before.arrays, after.arrays))
