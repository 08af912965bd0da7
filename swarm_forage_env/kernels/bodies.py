"""Between poses and the rows of a rigid-body engine: x, y, angle, vx, vy, spin."""

import math

from swarm_forage_env.arrays import Array, Bool, Float64, Int32, Int64
from swarm_forage_env.kernels.compiler import kernel
from swarm_forage_env.kernels.diff_drive import advance, wheels_to_arc
from swarm_forage_env.kernels.frames import wrap


@kernel
def write_bodies(
    pose: Float64[Array, "rows 3"],
    wheels: Float64[Array, "rows 2"],
    dt: float,
    axle: float,
    out_bodies: Float64[Array, "worlds bodies 6"],
) -> None:
    """Poses, and velocities that carry each robot along the chord of its arc in dt [s]."""
    n_worlds = out_bodies.shape[0]
    n_robots = pose.shape[0] // n_worlds
    for i in range(pose.shape[0]):
        body = out_bodies[i // n_robots, i % n_robots]
        speed, spin = wheels_to_arc(wheels[i, 0], wheels[i, 1], axle)
        middle = pose[i, 2] + 0.5 * spin * dt
        body[:3] = pose[i]
        body[3] = speed * math.cos(middle)
        body[4] = speed * math.sin(middle)
        body[5] = spin


@kernel
def may_touch(  # noqa: PLR0913 inputs first, then the output
    pose: Float64[Array, "rows 3"],
    wheels: Float64[Array, "rows 2"],
    pairs: Int32[Array, "capacity 2"],
    start: Int64[Array, " worlds_and_end"],
    arena: Float64[Array, "2"],
    radius: float,
    dt: float,
    out_touching: Bool[Array, " worlds"],
) -> None:
    """In which worlds a body can reach another, or a wall, within dt [s] at these wheel speeds."""
    n_worlds = out_touching.shape[0]
    n_robots = pose.shape[0] // n_worlds
    for w in range(n_worlds):
        out_touching[w] = False
        for i in range(w * n_robots, (w + 1) * n_robots):
            path = 0.5 * abs(wheels[i, 0] + wheels[i, 1]) * dt
            far_x, far_y = 0.5 * arena[0] - radius - path, 0.5 * arena[1] - radius - path
            if abs(pose[i, 0]) >= far_x or abs(pose[i, 1]) >= far_y:
                out_touching[w] = True
        for k in range(start[w], start[w + 1]):
            i, j = pairs[k, 0], pairs[k, 1]
            paths = 0.5 * (abs(wheels[i, 0] + wheels[i, 1]) + abs(wheels[j, 0] + wheels[j, 1])) * dt
            d = math.hypot(pose[j, 0] - pose[i, 0], pose[j, 1] - pose[i, 1])
            if d <= 2.0 * radius + paths:
                out_touching[w] = True


@kernel
def read_bodies(
    touching: Bool[Array, " worlds"],
    bodies: Float64[Array, "worlds numbers"],
    wheels: Float64[Array, "rows 2"],
    dt: float,
    axle: float,
    pose: Float64[Array, "rows 3"],
) -> None:
    """Poses after dt [s]: from rows of x, y and angle where bodies may touch, else by the chord."""
    n_robots = pose.shape[0] // bodies.shape[0]
    for i in range(pose.shape[0]):
        w = i // n_robots
        if touching[w]:
            at = 3 * (i % n_robots)
            pose[i, 0], pose[i, 1] = bodies[w, at], bodies[w, at + 1]
            pose[i, 2] = wrap(bodies[w, at + 2])
        else:
            drho, dtheta = wheels_to_arc(wheels[i, 0] * dt, wheels[i, 1] * dt, axle)
            pose[i, 0], pose[i, 1], pose[i, 2] = advance(
                pose[i, 0], pose[i, 1], pose[i, 2], drho, dtheta
            )
