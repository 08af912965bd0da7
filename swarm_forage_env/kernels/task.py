"""Foraging: where robots start, and what counts as a visit and a round trip."""

import math

from swarm_forage_env.arrays import (
    NEST,
    PREY,
    Array,
    Bool,
    Float32,
    Float64,
    Int8,
    Int32,
    Int64,
    UInt64,
)
from swarm_forage_env.kernels.compiler import kernel
from swarm_forage_env.kernels.frames import to_outer
from swarm_forage_env.kernels.ground import FLOOR, area_at
from swarm_forage_env.kernels.rng import symmetric, unit

TO_FIRST_NEST, TO_PREY, TO_NEST = 0, 1, 2


@kernel
def place_in_circle(
    radius: float,
    apart: float,
    streams: UInt64[Array, " robots"],
    out_pose: Float64[Array, "robots 3"],
) -> int:
    """Put robots at random into a circle about the origin, none closer than `apart` [m].

    Positions uniform among the free ones, headings uniform; when somebody finds no place,
    all start over. Returns how many found a place in the last try: fewer than asked for
    means that the circle is too full.
    """
    n_robots = out_pose.shape[0]
    placed = 0
    for _ in range(200):
        placed = 0
        while placed < n_robots and place_next(radius, apart, streams, placed, out_pose):
            placed += 1
        if placed == n_robots:
            break
    return placed


@kernel
def place_next(
    radius: float,
    apart: float,
    streams: UInt64[Array, " robots"],
    i: int,
    out_pose: Float64[Array, "robots 3"],
) -> bool:
    """Put robot i clear of robots 0 .. i - 1; false if 10,000 draws hit none of the free places."""
    for _ in range(10_000):
        r = radius * math.sqrt(unit(streams, i))
        angle = math.pi * symmetric(streams, i)
        x, y = r * math.cos(angle), r * math.sin(angle)
        if is_free(x, y, apart, out_pose, i):
            out_pose[i, 0], out_pose[i, 1] = x, y
            out_pose[i, 2] = math.pi * symmetric(streams, i)
            return True
    return False


@kernel
def is_free(x: float, y: float, apart: float, pose: Float64[Array, "robots 3"], n: int) -> bool:
    """No centre of the first n robots is closer to (x, y) than `apart` [m]."""
    for j in range(n):
        dx, dy = pose[j, 0] - x, pose[j, 1] - y
        if dx * dx + dy * dy < apart * apart:
            return False
    return True


@kernel
def next_leg(leg: int, area: int) -> tuple[int, bool]:
    """The leg after standing on an area, and whether that completes nest -> prey -> nest.

    Source: TR, Section 6.1.2 (the round trip).
    """
    if area == NEST:
        return TO_PREY, leg == TO_NEST
    if area == PREY and leg == TO_PREY:
        return TO_NEST, False
    return leg, False


@kernel
def score(  # noqa: PLR0913 inputs first, then the outputs
    pose: Float64[Array, "rows 3"],
    lost: Bool[Array, " rows"],
    known: Bool[Array, "rows areas"],
    areas: Float64[Array, "areas 2"],
    radius: float,
    ahead: float,
    half_time: int,
    ticks: Int64[Array, " worlds"],
    leg: Int8[Array, " rows"],
    round_trips: Int32[Array, " rows"],
    first_visit: Int64[Array, "rows areas"],
    path_ticks: Int64[Array, " rows"],
    lost_events: Int32[Array, " rows"],
    out_reward: Float32[Array, " rows"],
) -> None:
    """Book the visits, round trips and lost reports of one tick, in place.

    A robot visits an area when its middle ground sensor, `ahead` of its centre [m], is truly
    over it. It is on the path while it reports that it knows both areas.
    """
    n_robots = pose.shape[0] // ticks.shape[0]
    for i in range(pose.shape[0]):
        now = ticks[i // n_robots]
        lost_events[i] += lost[i]
        dx, dy = to_outer(ahead, 0.0, pose[i, 2])
        area = area_at(pose[i, 0] + dx, pose[i, 1] + dy, areas, radius)
        leg[i], completed = next_leg(leg[i], area)
        round_trips[i] += completed
        out_reward[i] = completed
        if area != FLOOR and first_visit[i, area] < 0:
            first_visit[i, area] = now
        if now > half_time and known[i, NEST] and known[i, PREY]:
            path_ticks[i] += 1
