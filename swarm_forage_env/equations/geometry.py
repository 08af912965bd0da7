"""Angles and frames. World frame: x along the arena's long side. Body frame: x ahead, y left."""

import math

from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.compiler import kernel
from swarm_forage_env.equations.elementary import atan2, hypot

Pose = Float64[Array, "3"]
"""x, y [m] and heading [rad]."""


@kernel
def wrap(angle: float) -> float:
    """Wrap an angle to [-pi, pi) [rad]."""
    if -math.pi <= angle < math.pi:
        return angle
    wrapped = angle - 2.0 * math.pi * math.floor((angle + math.pi) / (2.0 * math.pi))
    return max(wrapped, -math.pi) if wrapped < math.pi else -math.pi


@kernel
def range_and_bearing(dx: float, dy: float, theta: float) -> tuple[float, float]:
    """Return the range [m] and bearing [rad] of a point seen by a robot with heading theta.

        r = |(dx, dy)|
        b = atan2(dy, dx) - theta

    (dx, dy): from the robot to the point, world frame [m]. b: in the body frame, [-pi, pi).

    >>> range_and_bearing(0.0, 2.0, math.pi / 2)
    (2.0, 0.0)
    """
    return hypot(dx, dy), wrap(atan2(dy, dx) - theta)


@kernel
def to_body(dx: float, dy: float, c: float, s: float) -> tuple[float, float]:
    """Rotate a displacement from the outer to the body frame [m]; c, s: cos, sin of the heading.

    >>> to_body(0.0, 2.0, 0.0, 1.0)
    (2.0, 0.0)
    """
    return c * dx + s * dy, c * dy - s * dx


@kernel
def to_outer(ahead: float, left: float, c: float, s: float) -> tuple[float, float]:
    """Rotate a displacement from the body to the outer frame [m]; c, s: cos, sin of the heading.

    >>> to_outer(2.0, 0.0, 0.0, 1.0)
    (0.0, 2.0)
    """
    return c * ahead - s * left, s * ahead + c * left
