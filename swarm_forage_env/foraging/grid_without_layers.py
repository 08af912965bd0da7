"""Robots whose policy is everything on a GPU: what stands in the place of templates of layers.

Templates over the grid of `foraging/grid.py`, handed what those in their places are handed.
"""

from typing import Any

from swarm_forage_env.arrays import Array, Float64, Int8, Int64, UInt64
from swarm_forage_env.foraging.global_state import put_counts
from swarm_forage_env.foraging.policies import carry_out
from swarm_forage_env.interface import Kernel, LayerTemplates

cuda: Any
hear_words: Kernel
"""Free names of the templates: threads of the GPU, and a function of the task."""


def carry_out_on_grid(  # noqa: PLR0913 what `decide_on_grid` is handed
    robots: Array,
    minds: Array,
    memories: Array,
    shared: Array,
    settings: Array,
    trouble: Int64[Array, "4"],
    runs: Int8[Array, " worlds"],
) -> None:
    """Command what the policies say in the worlds that run. Free name: cuda."""
    w = cuda.blockIdx.x * cuda.blockDim.y + cuda.threadIdx.y
    n = robots.shape[1] if w < robots.shape[0] and runs[w] else 0
    for i in range(cuda.threadIdx.x, n, cuda.blockDim.x):
        carry_out(robots[w, i], minds[w, i])


def hear_words_on_grid(
    robots: Array, minds: Array, shared: Array, settings: Array, runs: Int8[Array, " worlds"]
) -> None:
    """Write what robots are told in the worlds that run. Free names: cuda, hear_words."""
    w = cuda.blockIdx.x * cuda.blockDim.y + cuda.threadIdx.y
    n = robots.shape[1] if w < robots.shape[0] and runs[w] else 0
    for i in range(cuda.threadIdx.x, n, cuda.blockDim.x):
        hear_words(robots, minds, w, i)


def forget_words_on_grid(  # noqa: PLR0913 what `forget_on_grid` is handed
    minds: Array,
    memories: Array,
    first_mind: Array,
    first_memory: Array,
    seeds: UInt64[Array, " worlds"],
    is_new: Int8[Array, " worlds"],
    noise: int,
) -> None:
    """Forget what the robots of new worlds said. Free name: cuda."""
    w = cuda.blockIdx.x * cuda.blockDim.y + cuda.threadIdx.y
    n = minds.shape[1] if w < minds.shape[0] and is_new[w] else 0
    for i in range(cuda.threadIdx.x, n, cuda.blockDim.x):
        minds[w, i] = first_mind[0]


def log_counts_on_grid(
    robots: Array,
    minds: Array,
    worlds: Array,
    learners: Int64[Array, " learners"],
    out: Float64[Array, "worlds learners infos"],
) -> None:
    """Write what is logged of each learner, as `write_log`: nobody believes anything.

    Free name: cuda.
    """
    w = cuda.blockIdx.x * cuda.blockDim.y + cuda.threadIdx.y
    n = out.shape[1] if w < out.shape[0] else 0
    for learner in range(cuda.threadIdx.x, n, cuda.blockDim.x):
        row = out[w, learner]
        put_counts(robots[w, learners[learner]], row)
        row[4] = row[5] = 0.0


WITHOUT_LAYERS = LayerTemplates(
    decide=carry_out_on_grid,
    observe=hear_words_on_grid,
    forget=forget_words_on_grid,
    log=log_counts_on_grid,
)
