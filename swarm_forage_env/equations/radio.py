"""The range-and-bearing radio: loss of messages, and noise of the measured range."""

import numpy as np

from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.compiler import kernel
from swarm_forage_env.equations.elementary import exp
from swarm_forage_env.equations.random_draws import Streams, normal, symmetric

POWER_GAP = np.array([0.0, 0.02, 0.05, 0.10, 0.15, 0.30, 0.45, 0.60])
POWER_MU = np.array([7.647, 7.597, 7.250, 7.085, 6.984, 6.917, 6.823, 6.829])
POWER_SIGMA = np.array([0.357, 0.319, 0.193, 0.153, 0.109, 0.122, 0.153, 0.142])
"""Parameters of the lognormal received power of the real board, by the gap between bodies [m].

Source: ARGoS3-epuck, range-and-bearing noise of the real board.
"""


@kernel
def loss(d: float, near: float, far: float, loss_near: float, loss_far: float) -> float:
    """Return the loss probability of a message over distance d [m], linear from near to far.

    Source: TR, Section 6.1; ANTS, Section 4.1.
    """
    along = min(max((d - near) / (far - near), 0.0), 1.0)
    return loss_near + (loss_far - loss_near) * along


@kernel
def mean_error(streams: Streams, column: int, frames: int, amplitude: float) -> float:
    """Draw the mean error of `frames` frames; the error of each is uniform in +- amplitude."""
    total = 0.0
    for _ in range(frames):
        total += symmetric(streams, column)
    return amplitude * total / frames


@kernel
def interpolate(x: float, xs: Float64[Array, " points"], ys: Float64[Array, " points"]) -> float:
    """Interpolate linearly between points at x >= xs[0]; constant beyond the last point."""
    last = xs.shape[0] - 1
    if x >= xs[last]:
        return float(ys[last])
    k = 0
    while x >= xs[k + 1]:
        k += 1
    slope = (ys[k + 1] - ys[k]) / (xs[k + 1] - xs[k])
    return float(slope * (x - xs[k]) + ys[k])


@kernel
def board_range(gap: float, streams: Streams, column: int) -> float:
    """Draw the gap [m] that one frame of the real board measures for a true gap [m].

        power = exp(mu + sigma z),  100 gap = exp(9.06422 - 0.00565075 power)

    z is standard normal; mu and sigma are interpolated linearly in the gap.

    Source: ARGoS3-epuck, range-and-bearing noise of the real board.
    """
    mu = interpolate(gap, POWER_GAP, POWER_MU)
    sigma = interpolate(gap, POWER_GAP, POWER_SIGMA)
    power = exp(mu + sigma * normal(streams, column))
    return 0.01 * exp(9.06422 - 0.00565075 * power)


@kernel
def mean_board_range(gap: float, streams: Streams, column: int, frames: int) -> float:
    """Draw the mean of the gaps that `frames` frames of the real board measure [m]."""
    total = 0.0
    for _ in range(frames):
        total += board_range(gap, streams, column)
    return total / frames
