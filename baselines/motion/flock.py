"""Equations of boids: the gains that adapt to the stimuli."""

from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.compiler import kernel

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
