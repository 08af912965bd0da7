"""Steering: accelerations for a desired direction."""

import math

from swarm_forage_env.compiler import kernel
from swarm_forage_env.equations.elementary import cos_sin, hypot


@kernel
def drive_to_pull(strength: float, turn: float, sharpest_turn: float) -> tuple[float, float]:
    """Return the acceleration (ahead, left) for a strength and a turn, as shares of the maximum.

        m = (strength + 1) / 2,  phi = pi s turn
        (m cos phi, m sin phi)

    strength in [-1, 1]: -1 keeps the velocity. turn in [-1, 1]: 1 turns left. s = sharpest_turn:
    sharpest turn, as a share of half a turn.

    >>> drive_to_pull(1.0, 0.0, 0.3)
    (1.0, 0.0)
    """
    m, phi = 0.5 * (strength + 1.0), math.pi * sharpest_turn * turn
    c, s = cos_sin(phi)
    return m * c, m * s


@kernel
def seek(x: float, y: float, vx: float, vy: float, speed: float) -> tuple[float, float]:
    """Return the unit acceleration that turns a velocity towards a direction; zeros if d is zero.

        u(v_max u(d) - v),  u(z) = z / |z|

    d = (x, y), v = (vx, vy), v_max = speed.

    Source: BOIDS, authors' code (the paper has u(d) alone).

    >>> seek(3.0, 0.0, 0.0, 0.0, 0.5)
    (1.0, 0.0)
    """
    size = hypot(x, y)
    if size == 0.0:
        return 0.0, 0.0
    dx, dy = speed * x / size - vx, speed * y / size - vy
    change = hypot(dx, dy)
    return (dx / change, dy / change) if change > 0.0 else (0.0, 0.0)
