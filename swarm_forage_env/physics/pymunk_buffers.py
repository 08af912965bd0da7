"""Kernels that move robots with Chipmunk, the C library that pymunk wraps, without Python.

They call only Chipmunk functions with addresses and scalars as arguments: the calling convention
of vectors depends on the platform. Bodies are read and written as in `pymunk.batch`.
"""

import ctypes
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from llvmlite.binding import add_symbol
from numba.core import config
from numba.core.types import ExternalFunction, Number, float64, intp, void
from pymunk._chipmunk import ffi, lib

from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.compiler import kernel
from swarm_forage_env.epuck.contacts import is_near_obstacle, is_near_walls
from swarm_forage_env.epuck.records import EpuckState, EpuckWorldState
from swarm_forage_env.epuck.surroundings import COUNT, FIRST, Neighbours
from swarm_forage_env.epuck.tick import set_wheels
from swarm_forage_env.equations.differential_drive import wheels_to_arc
from swarm_forage_env.equations.elementary import cos_sin, hypot
from swarm_forage_env.equations.geometry import wrap
from swarm_forage_env.equations.obstacles import Capsules
from swarm_forage_env.record import Record, field
from swarm_forage_env.ticks import Arrays

PLAIN: Mapping[Number, type[Any]] = {intp: ctypes.c_size_t, float64: ctypes.c_double}
"""Types of arguments if numba is disabled."""


def address_of(pointer: object) -> int:
    """Return the address in a pointer of pymunk."""
    return int(ffi.cast("uintptr_t", pointer))


def _function(name: str, *arguments: Number) -> Callable[..., None]:
    address = address_of(ffi.addressof(lib, name))
    if config.DISABLE_JIT:
        return ctypes.CFUNCTYPE(None, *(PLAIN[each] for each in arguments))(address)
    add_symbol(name, address)
    return ExternalFunction(name, void(*arguments))


step_space = _function("cpSpaceStep", intp, float64)
"""Advance the space at an address by a time [s]."""

each_body = _function("cpSpaceEachBody", intp, intp, intp)
"""Call a function for each body of a space; arguments: addresses of space, function, its data."""


SUBSTEPS = 2

_FLOATS = np.dtype(
    {
        "names": ["num", "max", "arr"],
        "formats": [np.int32, np.int32, np.intp],
        "offsets": [ffi.offsetof("pmFloatArray", name) for name in ("num", "max", "arr")],
        "itemsize": ffi.sizeof("pmFloatArray"),
    }
)
"""Pymunk's list of floats: length, capacity and address of the values."""


class SpaceMemory(Record):
    """Record of a pymunk space for kernels: its addresses, and the buffers of its bodies."""

    at: int = field(np.intp)
    """Address of the space."""
    writer: int = field(np.intp)
    """Address of the function that writes a body."""
    reader: int = field(np.intp)
    """Address of the function that reads a body."""
    to_write: int = field(np.intp)
    """Address of the argument of `writer`: the fields and the list that holds their values."""
    to_read: int = field(np.intp)
    """Address of the argument of `reader`."""
    writing: Any = field(_FLOATS)
    """Pymunk's list with the values of `written`."""
    reading: Any = field(_FLOATS)
    """Pymunk's list with the values of `read`."""
    written: Float64[Array, "bodies 6"] = field(np.float64, "bodies", 6)
    """x, y, angle, vx, vy and spin of each body; the static body of the walls is last."""
    read: Float64[Array, "rows 3"] = field(np.float64, "rows", 3)
    """x, y and angle of each body; has spare rows, since pymunk reallocates a full list."""


@kernel
def path_of(robot: EpuckState, dt: float) -> float:
    """Return the path of the centre of a robot in dt [s] at its wheel speeds [m]."""
    return float(0.5 * abs(robot.wheels[0] + robot.wheels[1]) * dt)


@kernel
def may_touch(swarm: Array, near: Neighbours, world: EpuckWorldState, obstacles: Capsules) -> bool:
    """Return whether any robot can reach another robot, a wall or an obstacle within the tick.

    `near` lists the neighbours before the tick.
    """
    for i in range(swarm.shape[0]):
        robot = swarm[i]
        path = path_of(robot, world.dt)
        if is_near_walls(robot, world, path) or is_near_obstacle(robot, world, obstacles, path):
            return True
        for k in range(FIRST, FIRST + near[i, COUNT]):
            other = swarm[near[i, k]]
            paths = path + path_of(other, world.dt)
            dx, dy = other.pose[0] - robot.pose[0], other.pose[1] - robot.pose[1]
            if hypot(dx, dy) <= 2.0 * world.radius + paths:
                return True
    return False


@kernel
def write_bodies(swarm: Array, world: EpuckWorldState, space: SpaceMemory) -> None:
    """Write poses and velocities of the robots to the bodies; a velocity follows the chord."""
    for i in range(swarm.shape[0]):
        robot, body = swarm[i], space.written[i]
        speed, spin = wheels_to_arc(robot.wheels[0], robot.wheels[1], world.axle)
        c, s = cos_sin(robot.pose[2] + 0.5 * spin * world.dt)
        body[0], body[1], body[2] = robot.pose[0], robot.pose[1], robot.pose[2]
        body[3], body[4], body[5] = speed * c, speed * s, spin
    space.writing.num = 0
    each_body(space.at, space.writer, space.to_write)


@kernel
def read_bodies(swarm: Array, space: SpaceMemory) -> None:
    """Read the poses of the bodies of a space into the robots."""
    space.reading.num = 0
    each_body(space.at, space.reader, space.to_read)
    for i in range(swarm.shape[0]):
        pose = swarm[i].pose
        pose[0], pose[1] = space.read[i, 0], space.read[i, 1]
        pose[2] = wrap(space.read[i, 2])


@kernel
def move_world(world_arrays: Arrays, w: int, n_robots: int) -> None:
    """Set the wheel speeds; move the robots with Chipmunk if bodies may touch in this tick."""
    robots, worlds, near, _, obstacles, _, _, spaces = world_arrays
    swarm, world, space = robots[w], worlds[w], spaces[w]
    for i in range(n_robots):
        set_wheels(swarm[i], world)
    standing = obstacles[w, : world.n_obstacles]
    if n_robots > 0 and may_touch(swarm, near[w], world, standing):
        write_bodies(swarm, world, space)
        for _ in range(SUBSTEPS):
            step_space(space.at, world.dt / SUBSTEPS)
        read_bodies(swarm, space)
        world.has_moved = True
