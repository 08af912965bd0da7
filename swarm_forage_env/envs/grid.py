"""A step of an environment on a GPU: actions in, observations and rewards out, a thread a learner.

Templates over the same grid as those of the worlds. An action of the caller's is read only.
"""

from typing import Any

import numpy as np

from swarm_forage_env.arrays import Array, Float32, Float64, Int64
from swarm_forage_env.compiler import kernel
from swarm_forage_env.envs.observations import normalise_row, write_direction
from swarm_forage_env.interface import REFUSED, Kernel

cuda: Any
command: Kernel
show: Kernel
put: Kernel
"""Free names of the templates: threads of the GPU, a form of steering, a policy's functions."""

HALF, ONE = np.float32(0.5), np.float32(1.0)


@kernel
def as_given(first: float, second: float, sharpest_turn: float) -> tuple[float, float]:
    """The two numbers are the command."""
    return first, second


def check_actions(
    given: Float32[Array, "worlds learners numbers"],
    low: Float32[Array, " numbers"],
    high: Float32[Array, " numbers"],
    trouble: Int64[Array, "3"],
) -> None:
    """Note a world in which a number of an action is not within its bounds; NaN is not.

    Free name: cuda.
    """
    w = cuda.blockIdx.x * cuda.blockDim.y + cuda.threadIdx.y
    n = given.shape[1] if w < given.shape[0] else 0
    for learner in range(cuda.threadIdx.x, n, cuda.blockDim.x):
        for k in range(given.shape[2]):
            if not low[k] <= given[w, learner, k] <= high[k]:
                cuda.atomic.max(trouble, REFUSED, w + 1)


def take_actions(  # noqa: PLR0913 what an action is
    robots: Array,
    learners: Int64[Array, " learners"],
    given: Float32[Array, "worlds learners numbers"],
    raw: Float32[Array, "worlds learners numbers"],
    n_symmetric: int,
    steers_at: int,
    sharpest_turn: float,
    earned: Float64[Array, "worlds robots"],
) -> None:
    """Write the actions of the learners, and forget what was earned before.

    The first `n_symmetric` numbers are weights in [-1, 1]; those from `steers_at` on, if it is not
    negative, steer. Free names: cuda, command, put.
    """
    w = cuda.blockIdx.x * cuda.blockDim.y + cuda.threadIdx.y
    n = given.shape[1] if w < given.shape[0] else 0
    first, step = cuda.threadIdx.x, cuda.blockDim.x
    for i in range(first, robots.shape[1] if n > 0 else 0, step):
        earned[w, i] = 0.0
    for learner in range(first, n, step):
        row = raw[w, learner]
        for k in range(given.shape[2]):
            number = given[w, learner, k]
            row[k] = HALF * (number + ONE) if k < n_symmetric else number
        if steers_at >= 0:
            left, right = command(row[steers_at], row[steers_at + 1], sharpest_turn)
            row[steers_at], row[steers_at + 1] = left, right
        put(robots[w, learners[learner]], row)


def tell(  # noqa: PLR0913 what is told, and to whom
    robots: Array,
    minds: Array,
    learners: Int64[Array, " learners"],
    n_slots: int,
    earned: Float64[Array, "worlds robots"],
    is_team: bool,
    direction: Int64[Array, "2"],
    bound: Float32[Array, " numbers"],
    squashes: Array,
    out: Float32[Array, "worlds learners numbers"],
    rewards: Float64[Array, "worlds learners"],
) -> None:
    """Write what every learner observes, and what it is given: its own, or its team's mean.

    `direction` is where the observed target starts, or -1, and where its direction goes; numbers
    without bounds are left as they are. Free names: cuda, show.
    """
    w = cuda.blockIdx.x * cuda.blockDim.y + cuda.threadIdx.y
    n = out.shape[1] if w < out.shape[0] else 0
    for learner in range(cuda.threadIdx.x, n, cuda.blockDim.x):
        i, row = learners[learner], out[w, learner]
        show(robots[w, i], minds[w, i], n_slots, row)
        if direction[0] >= 0:
            write_direction(row, direction[0], direction[1])
        if bound.shape[0] > 0:
            normalise_row(row, bound, squashes)
        given = earned[w, i]
        if is_team:
            given = 0.0
            for other in range(earned.shape[1]):
                given += earned[w, other]
            given /= earned.shape[1]
        rewards[w, learner] = given
