"""Infrared proximity sensors: eight rays from the rim of the body, and the distance response."""

import math

import numpy as np

from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.compiler import kernel
from swarm_forage_env.equations.obstacles import ray_to_round_end

PROXIMITY_ANGLES = np.radians([-17.0, -50.0, -90.0, -150.0, 150.0, 90.0, 50.0, 17.0])
"""Directions of the sensors ps0 .. ps7 in the body frame [rad], counter-clockwise positive.

Source: ARGoS3-epuck, ci_epuck_proximity_sensor.cpp.
"""

SENSING_RANGE = 0.05
"""Distance from the rim beyond which a sensor reads 0 [m]."""

_COS = 0.9563047559630354, 0.6427876096865394, 6.123233995736766e-17, -0.8660254037844387
_SIN = 0.29237170472273677, 0.766044443118978, 1.0, 0.49999999999999994
RAY_COS = np.array([*_COS, *reversed(_COS)])
RAY_SIN = np.array([*(-each for each in _SIN), *reversed(_SIN)])
"""Cosine and sine of PROXIMITY_ANGLES; the last bits of NumPy's differ between machines."""


@kernel
def response(d: float) -> float:
    """Return the noise-free reading of an infrared sensor at distance d from the rim [m].

        298.701 d^2 - 36.8961 d + 1.08212,  in [0, 1],  0 beyond 5 cm

    Source: ARGoS3-epuck, CalculateReading.
    """
    if d > SENSING_RANGE:
        return 0.0
    return min(max((298.701 * d - 36.8961) * d + 1.08212, 0.0), 1.0)


@kernel
def ray_to_disc(ahead: float, left: float, ray: int, radius: float) -> float:
    """Return the distance along ray `ray` from the rim to a disc at (ahead, left), body frame [m].

    `radius` is that of both bodies [m]. Infinite if the ray misses.
    """
    far = ray_to_round_end(ahead, left, float(RAY_COS[ray]), float(RAY_SIN[ray]), radius)
    return max(far - radius, 0.0)


@kernel
def ray_to_walls(
    x: float, y: float, c: float, s: float, arena: Float64[Array, "2"], radius: float
) -> float:
    """Return the distance from the rim to the walls along a direction with cosine c and sine s [m].

    (x, y) is the centre of the body, inside the arena; all in the world frame [m]. Infinite
    beyond SENSING_RANGE.
    """
    far = radius + SENSING_RANGE
    to_x = 0.5 * arena[0] - (x if c > 0.0 else -x)
    to_y = 0.5 * arena[1] - (y if s > 0.0 else -y)
    if to_x > abs(c) * far and to_y > abs(s) * far:
        return math.inf
    along_x = to_x / abs(c) if c != 0.0 else math.inf
    along_y = to_y / abs(s) if s != 0.0 else math.inf
    return max(min(along_x, along_y) - radius, 0.0)
