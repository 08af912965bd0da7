"""Lanes: the threads that share the robots of a world, one on a CPU and many on a GPU.

A barrier stands wherever a robot reads what another lane has written:

    for i in range(lane(), n, lanes()):
        drive(swarm[i], world)
    barrier()

A template gets these names when it is bound. On a CPU they are 0, 1 and nothing, and one call runs
a chunk of worlds, world by world. On a GPU a block of threads holds a few whole worlds:
`cuda.threadIdx.y` tells which of them, and `cuda.threadIdx.x` is the lane.
"""

from collections.abc import Callable
from types import ModuleType

Functions = dict[str, Callable[..., int | None]]


def lane() -> int:
    """The number of this lane: 0."""
    return 0


def lanes() -> int:
    """How many lanes share a world: 1."""
    return 1


def barrier() -> None:
    """Wait for the other lanes: there are none."""


def first_world(first: int) -> int:
    """The first world of this call."""
    return first


def end_world(last: int) -> int:
    """The first world after those of this call."""
    return last


ON_CPU: Functions = {each.__name__: each for each in (lane, lanes, barrier, first_world, end_world)}
"""The names on a CPU."""


def on_gpu(cuda: ModuleType) -> Functions:
    """The names on a GPU, of numba's module for GPUs or of what simulates it.

    A thread of a GPU runs one world, which may lie beyond the last: it has no robots then, and
    meets the others at their barriers.
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
