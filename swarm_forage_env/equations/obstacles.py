"""Obstacles: every disc, and every wall of a polygon, is a capsule.

A capsule (ax, ay, bx, by, radius) is the set of points within a radius of a line segment, its
axis, given by its two ends, world frame [m]. The ends of a disc coincide, and a thin wall has
radius 0.
"""

import math

from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.compiler import kernel
from swarm_forage_env.equations.elementary import hypot
from swarm_forage_env.equations.geometry import Pose

Capsule = Float64[Array, "5"]

Capsules = Float64[Array, "obstacles 5"]

ON_AXIS = 1e-9
"""Distance to an axis below which a point counts as on it [m]; the way out is then undefined."""


@kernel
def from_axis(x: float, y: float, capsule: Capsule) -> tuple[float, float]:
    """Return the displacement from the nearest point of a capsule's axis to the point (x, y) [m].

    Source: textbook (projection on a segment).
    """
    ux, uy = capsule[2] - capsule[0], capsule[3] - capsule[1]
    length_squared = ux * ux + uy * uy
    share = 0.0
    if length_squared > 0.0:
        share = ((x - capsule[0]) * ux + (y - capsule[1]) * uy) / length_squared
        share = min(max(share, 0.0), 1.0)
    return x - (capsule[0] + share * ux), y - (capsule[1] + share * uy)


@kernel
def keep_out(pose: Pose, capsule: Capsule, radius: float) -> float:
    """Move a disc straight out of a capsule, in place; returns their overlap [m].

    A disc with its centre on the axis leaves to the left, or along x if the axis is a point.
    """
    dx, dy = from_axis(pose[0], pose[1], capsule)
    apart = radius + capsule[4]
    if dx * dx + dy * dy >= apart * apart:
        return 0.0
    d = hypot(dx, dy)
    if d > ON_AXIS:
        nx, ny = dx / d, dy / d
    else:
        ux, uy = capsule[2] - capsule[0], capsule[3] - capsule[1]
        length = hypot(ux, uy)
        nx, ny = (-uy / length, ux / length) if length > 0.0 else (1.0, 0.0)
    pose[0] += (apart - d) * nx
    pose[1] += (apart - d) * ny
    short: float = apart - d
    return short


@kernel
def ray_to_round_end(cx: float, cy: float, u: float, v: float, radius: float) -> float:
    """Return the distance along the direction (u, v) to a disc with its centre at (cx, cy) [m].

    (cx, cy) is relative to the start of the ray. Infinite if the ray misses.
    """
    along, across = cx * u + cy * v, cy * u - cx * v
    if along <= 0.0 or abs(across) >= radius:
        return math.inf
    return max(along - math.sqrt(radius * radius - across * across), 0.0)


@kernel
def ray_to_side(px: float, py: float, dx: float, dy: float, ux: float, uy: float) -> float:
    """Return the distance along (dx, dy) to the segment from (px, py) to (px + ux, py + uy) [m].

        t = p x u / (d x u),  s = p x d / (d x u),  a hit where t >= 0 and 0 <= s <= 1

    (px, py) is relative to the start of the ray. Infinite if the ray misses.

    Source: textbook (intersection of two lines).
    """
    cross = dx * uy - dy * ux
    if cross == 0.0:
        return math.inf
    t, s = (px * uy - py * ux) / cross, (px * dy - py * dx) / cross
    return t if t >= 0.0 and 0.0 <= s <= 1.0 else math.inf


@kernel
def ray_to_capsule(x: float, y: float, u: float, v: float, capsule: Capsule) -> float:
    """Return the distance from (x, y), outside a capsule, to it along (u, v) [m], or infinity."""
    ax, ay, radius = capsule[0] - x, capsule[1] - y, capsule[4]
    bx, by = capsule[2] - x, capsule[3] - y
    nearest = ray_to_round_end(ax, ay, u, v, radius)
    ux, uy = bx - ax, by - ay
    length = hypot(ux, uy)
    if length == 0.0:
        return nearest
    nearest = min(nearest, ray_to_round_end(bx, by, u, v, radius))
    nx, ny = -radius * uy / length, radius * ux / length
    left = ray_to_side(ax + nx, ay + ny, u, v, ux, uy)
    right = ray_to_side(ax - nx, ay - ny, u, v, ux, uy)
    return min(nearest, left, right)


@kernel
def is_between(x: float, y: float, other_x: float, other_y: float, capsule: Capsule) -> bool:
    """Return whether a capsule blocks the line between two points outside it, world frame [m]."""
    d = hypot(other_x - x, other_y - y)
    if d == 0.0:
        return False
    return ray_to_capsule(x, y, (other_x - x) / d, (other_y - y) / d, capsule) < d
