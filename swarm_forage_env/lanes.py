"""Lanes: the threads that share the robots of a world, one on a CPU and many on a GPU.

A barrier separates the writes of a lane from the reads of other lanes:

    for i in range(lane(), n, lanes()):
        drive(swarm[i], world)
    barrier()

A template gets these functions when it is bound. On a CPU the lane is 0 of 1, barriers do nothing,
and one call runs a chunk of worlds, world by world. On a GPU a block of threads runs a few whole
worlds: `cuda.threadIdx.y` is the world's index in the block, `cuda.threadIdx.x` that of the lane.
"""

from collections.abc import Callable
from types import ModuleType

Functions = dict[str, Callable[..., int | None]]


def lane() -> int:
    """Return the index of this lane: 0."""
    return 0


def lanes() -> int:
    """Return the number of lanes that share a world: 1."""
    return 1


def barrier() -> None:
    """Wait for the other lanes; on a CPU there are none."""


def first_world(first: int) -> int:
    """Return the first world of this call."""
    return first


def end_world(last: int) -> int:
    """Return the first world after those of this call."""
    return last


ON_CPU: Functions = {each.__name__: each for each in (lane, lanes, barrier, first_world, end_world)}
"""These functions on a CPU, by name."""


def on_gpu(cuda: ModuleType) -> Functions:
    """Return these functions on a GPU, given numba's module for GPUs or its simulator.

    Each thread runs one world. A thread beyond the last world has no robots, but reaches all
    barriers.
    """

    def lane() -> int:
        return int(cuda.threadIdx.x)

    def lanes() -> int:
        return int(cuda.blockDim.x)

    def barrier() -> None:
        cuda.syncthreads()

    def first_world(first: int) -> int:
        return int(cuda.blockIdx.x * cuda.blockDim.y + cuda.threadIdx.y)

    def end_world(last: int) -> int:
        return int(cuda.blockIdx.x * cuda.blockDim.y + cuda.threadIdx.y + 1)

    return {each.__name__: each for each in (lane, lanes, barrier, first_world, end_world)}
