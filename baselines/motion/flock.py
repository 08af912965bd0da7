"""Flock: the gains of the rules of boids, and the pull of all rules.

Smith et al. 2021 (BOIDS), Sections 3 and 4.
"""

from swarm_forage_env.arrays import Array, Float32, Float64
from swarm_forage_env.compiler import kernel
from swarm_forage_env.equations.elementary import hypot
from swarm_forage_env.equations.steering import seek
from swarm_forage_env.record import Numbers

ALIGN, SEPARATE, COHERE, HOME, GOAL = range(5)
"""The rules, in the order of the ways and of the gains."""

N_RULES = 5

Vector = Float32[Array, "2"]

Ways = Float32[Array, "5 2"] | tuple[Vector, Vector, Vector, Vector, Vector]
"""Where each rule points, body frame."""

Gains = Float64[Array, "5"]  # the gain of each rule

Stimuli = Float32[Array, "3"] | tuple[float, float, float]
"""Robots seen, uncertainty and distance from dead reckoning: each as a share of the highest."""


@kernel
def adaptive_gains(
    rho: float, s: float, e: float, d_g: float, d_h: float, out_gains: Gains
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
def choose_gains(ways: Ways, stimuli: Stimuli, numbers: Numbers, out_gains: Gains) -> None:
    """Write the fixed gains or, if `adaptive`, those for the stimuli (rho, s, e) and the ways."""
    if numbers.adaptive > 0.0:
        goal, home = ways[GOAL], ways[HOME]
        d_g, d_h = hypot(goal[0], goal[1]) / numbers.side, hypot(home[0], home[1]) / numbers.side
        adaptive_gains(stimuli[0], stimuli[1], stimuli[2], d_g, d_h, out_gains)
    else:
        for rule in range(N_RULES):
            out_gains[rule] = numbers.gains[rule]


@kernel
def sum_of_rules(
    gains: Gains, ways: Ways, velocity: Vector, max_speed: float
) -> tuple[float, float]:
    """The direction in which all rules together pull a robot: a unit vector, or zeros.

        A = sum over rules of K F,  A / |A|

    Each force F seeks the way of its rule from the present velocity.

    Source: BOIDS, Eq. 24 and 32.
    """
    x, y = 0.0, 0.0
    vx, vy = float(velocity[0]), float(velocity[1])
    for rule in range(N_RULES):
        way = ways[rule]
        fx, fy = seek(float(way[0]), float(way[1]), vx, vy, max_speed)
        x += gains[rule] * fx
        y += gains[rule] * fy
    size = hypot(x, y)
    return (x / size, y / size) if size > 0.0 else (0.0, 0.0)
