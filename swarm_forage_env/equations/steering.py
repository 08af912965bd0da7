"""Steering: from a direction and a velocity to a change of velocity."""

import math

from swarm_forage_env.compiler import kernel


@kernel
def seek(x: float, y: float, vx: float, vy: float, speed: float) -> tuple[float, float]:
    """The unit vector that turns a velocity towards a direction; zeros for no direction.

        u(v_max u(d) - v),  u(z) = z / |z|

    d = (x, y), v = (vx, vy), v_max = speed.

    Source: BOIDS, authors' code; the paper has u(d) alone.

    >>> seek(3.0, 0.0, 0.0, 0.0, 0.5)
    (1.0, 0.0)
    """
    size = math.hypot(x, y)
    if size == 0.0:
        return 0.0, 0.0
    dx, dy = speed * x / size - vx, speed * y / size - vy
    change = math.hypot(dx, dy)
    return (dx / change, dy / change) if change > 0.0 else (0.0, 0.0)
