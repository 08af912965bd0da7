"""Ticks: the work of worlds between two cuts of a learner, in one source for CPU and GPU.

    decide -> move -> tick -> observe -> [the cut] -> decide ...

Worlds are independent of each other, so that several ticks run in one compiled call, world by
world, or in one GPU launch, in which a block of threads runs whole worlds.
"""

from collections.abc import Sequence
from functools import reduce
from typing import Any

from swarm_forage_env.arrays import Array, Int8, Int64
from swarm_forage_env.compiler import bind_row, kernel
from swarm_forage_env.equations.random_draws import first_word
from swarm_forage_env.interface import CompiledLayers, Kernel
from swarm_forage_env.templates import is_row_template, row_template

lane: Kernel
lanes: Kernel
barrier: Kernel
first_world: Kernel
end_world: Kernel
decide_world: Kernel
move_world: Kernel
tick_world: Kernel
observe_world: Kernel
place_world: Kernel
set_stream: Kernel
decide_before: Kernel
decide_after: Kernel
observe_before: Kernel
observe_after: Kernel
"""Free names of the templates: lanes, and row templates of a task, an engine and a controller."""

SKIP, RUN, START = range(3)
"""Mode of a world in a call: unchanged; runs ticks; or senses and observes before the first."""

NO_ERROR, TOO_MANY_NEAR, NOT_FINITE, REFUSED, NO_ROOM = range(5)
"""Kinds of error in a world, which compiled functions note and Python raises."""

N_ERRORS = 5

Errors = Int64[Array, " worlds_and_one"]
"""Error code of each world, as written by `note`; the last element is 1 if there is any."""

Modes = Int8[Array, " worlds"]
"""Mode of each world in a call."""

Arrays = tuple[Any, ...]
"""Arrays of all worlds, as a task or a controller keeps them."""


@kernel
def note(errors: Errors, w: int, kind: int, robot: int) -> None:
    """Write the error code of a world and a robot, and set the last element to 1."""
    errors[w] = kind + N_ERRORS * robot
    errors[errors.shape[0] - 1] = 1


@row_template
def run_world(  # noqa: PLR0913 what runs, how, which world, how long
    world_arrays: Arrays,
    layer_arrays: Arrays,
    mode: int,
    errors: Errors,
    w: int,
    n_robots: int,
    n_ticks: int,
) -> None:
    """Run some ticks of a world in mode RUN or START; in mode SKIP, `n_robots` is 0.

    After an invalid command or weight, the world stands for the remaining ticks. All lanes of a
    block reach every barrier, including those of worlds without robots to run.
    """
    for _ in range(n_ticks):
        n_moving = 0 if mode == START else n_robots
        decide_world(world_arrays, layer_arrays, errors, w, n_moving)
        barrier()
        if errors[w] % N_ERRORS == NOT_FINITE:
            n_robots = n_moving = 0
        move_world(world_arrays, w, n_moving)
        barrier()
        tick_world(world_arrays, errors, w, n_robots, n_moving)
        barrier()
        observe_world(world_arrays, layer_arrays, w, n_robots)
        barrier()


def run_ticks(  # noqa: PLR0913 what runs, how, which worlds, how long
    world_arrays: Arrays,
    layer_arrays: Arrays,
    modes: Modes,
    errors: Errors,
    first: int,
    last: int,
    n_ticks: int,
) -> None:
    """Run some ticks of the worlds first .. last - 1, each in its mode."""
    for each in range(first_world(first), end_world(last)):
        w = min(each, last - 1)
        n_robots = world_arrays[0].shape[1] if each < last and modes[w] != SKIP else 0
        run_world(world_arrays, layer_arrays, modes[w], errors, w, n_robots, n_ticks)


@row_template
def restart_world(  # noqa: PLR0913 what worlds start from, which one, and how many robots
    world_arrays: Arrays,
    layer_arrays: Arrays,
    starts: Arrays,
    noise: int,
    errors: Errors,
    w: int,
    n: int,
) -> None:
    """Place the robots of one world and reset their layers, for `begin_worlds`."""
    minds, memories = layer_arrays[0], layer_arrays[1]
    first_robot, first_mind, first_memory, seeds, places, poses = starts
    place_world(world_arrays, first_robot[0], seeds[w], places[w], poses[w], errors, w, n)
    for i in range(lane(), n, lanes()):
        minds[w, i], memories[w, i] = first_mind[0], first_memory[0]
        set_stream(memories[w, i], first_word(seeds[w], i, noise))


def begin_worlds(
    world_arrays: Arrays,
    layer_arrays: Arrays,
    starts: Arrays,
    noise: int,
    modes: Modes,
    errors: Errors,
) -> None:
    """Place the robots of all worlds whose mode is START, and reset their layers.

    `starts` holds the initial records of a robot, of its mind and of its memory, the seed of every
    world, and buffers for placing robots; `noise` is the source of noise of the motions.
    """
    last = world_arrays[0].shape[0]
    for each in range(first_world(0), end_world(last)):
        w = min(each, last - 1)
        n = world_arrays[0].shape[1] if each < last and modes[w] == START else 0
        restart_world(world_arrays, layer_arrays, starts, noise, errors, w, n)


@kernel
def nothing(*arrays: object) -> None:
    """Do nothing; this replaces a stage of a tick that is skipped."""


STAGES = {
    "decide": "decide_world",
    "engine": "move_world",
    "tick": "tick_world",
    "observe": "observe_world",
}
"""Row template of each stage of a tick, in order."""


def only(*stages: str) -> dict[str, Kernel]:
    """Return replacements for all other stages, so that only these are run."""
    return {template: nothing for stage, template in STAGES.items() if stage not in stages}


@row_template
def decide_both(
    world_arrays: Arrays, layer_arrays: Arrays, errors: Errors, w: int, n_robots: int
) -> None:
    """Decide with two sets of layers in a world."""
    decide_before(world_arrays, layer_arrays[0], errors, w, n_robots)
    decide_after(world_arrays, layer_arrays[1], errors, w, n_robots)


@row_template
def observe_both(world_arrays: Arrays, layer_arrays: Arrays, w: int, n_robots: int) -> None:
    """Observe with two sets of layers in a world."""
    observe_before(world_arrays, layer_arrays[0], w, n_robots)
    observe_after(world_arrays, layer_arrays[1], w, n_robots)


def joined(layers: Sequence[CompiledLayers]) -> CompiledLayers:
    """Join several sets of layers, each with its own robots, for one call on a CPU."""
    return reduce(_both, layers)


def _both(before: CompiledLayers, after: CompiledLayers) -> CompiledLayers:
    functions = {}
    for stage, template in (("decide", decide_both), ("observe", observe_both)):
        each = {}
        for order, layers in (("before", before), ("after", after)):
            own = layers.functions[f"{stage}_world"]
            each[f"{stage}_{order}"] = own
            if is_row_template(own):
                each[f"{stage}_{order}"] = bind_row(own, layers.functions)
        functions[f"{stage}_world"] = bind_row(template, each)
    return CompiledLayers(functions, (before.arrays, after.arrays))
