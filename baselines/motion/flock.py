"""Kernels of boids: the gains, and the pull of all rules."""

import numpy as np

from swarm_forage_env.arrays import Array, Bool, Float32, Float64
from swarm_forage_env.kernels.compiler import kernel
from swarm_forage_env.kernels.steering import seek

ALIGN, SEPARATE, COHERE, HOME, GOAL = range(5)
"""The rules, in the order of the gains."""


@kernel
def adaptive_gains(
    rho: float, s: float, e: float, d_g: float, d_h: float, out_gains: Float64[Array, "5"]
) -> None:
    """The gains for the stimuli of a robot.

        K_a = rho + (1 - d_h) + e
        K_s = (1 - e) + (1 - d_g) + (1 - s)
        K_c = s + e + d_h
        K_h = s + e + (1 - d_h)
        K_g = (1 - s) + (1 - e) + (1 - d_g)

    rho: robots seen, as a share of all; s: norm of the covariance, e: distance from dead
    reckoning, each as a share of the highest allowed; d_g, d_h: distance to the goal and to
    home, as a share of the side of the world.

    Source: BOIDS, Eq. 33 to 37.
    """
    out_gains[ALIGN] = rho + (1.0 - d_h) + e
    out_gains[SEPARATE] = (1.0 - e) + (1.0 - d_g) + (1.0 - s)
    out_gains[COHERE] = s + e + d_h
    out_gains[HOME] = s + e + (1.0 - d_h)
    out_gains[GOAL] = (1.0 - s) + (1.0 - e) + (1.0 - d_g)


@kernel
def flock(  # noqa: PLR0913 inputs first, then the output
    ways: Float32[Array, "rows 5 2"],
    velocity: Float32[Array, "rows 2"],
    stimuli: Float32[Array, "rows 3"],
    arrived: Bool[Array, " rows"],
    fixed: Float64[Array, "5"],
    numbers: Array,
    gains: Float64[Array, "5"],
    out_pull: Float32[Array, "rows 2"],
) -> None:
    """The pull of all rules on every robot: a unit vector of its body frame, or zeros.

        A = sum over rules of K F,  pull = A / |A|

    Source: BOIDS, Eq. 24 and 32.
    """
    for i in range(out_pull.shape[0]):
        gains[:] = fixed
        if numbers[0]["adaptive"] > 0.0:
            side = numbers[0]["side"]
            d_g = np.hypot(ways[i, GOAL, 0], ways[i, GOAL, 1]) / side
            d_h = np.hypot(ways[i, HOME, 0], ways[i, HOME, 1]) / side
            adaptive_gains(stimuli[i, 0], stimuli[i, 1], stimuli[i, 2], d_g, d_h, gains)
        if arrived[i]:
            gains[GOAL] = 0.0
        x, y = 0.0, 0.0
        for rule in range(5):
            fx, fy = seek(
                float(ways[i, rule, 0]), float(ways[i, rule, 1]),
                float(velocity[i, 0]), float(velocity[i, 1]), numbers[0]["max_speed"],
            )  # fmt: skip
            x += gains[rule] * fx
            y += gains[rule] * fy
        size = np.hypot(x, y)
        out_pull[i, 0] = x / size if size > 0.0 else 0.0
        out_pull[i, 1] = y / size if size > 0.0 else 0.0
