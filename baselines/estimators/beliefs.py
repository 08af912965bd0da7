"""What robots believe: one structure of arrays for a block of worlds."""

from dataclasses import dataclass, fields

import numpy as np

from swarm_forage_env.arrays import Array, Bool, Float64, Int8, Int32, checked

MEMORY = 8
"""Recent partners a robot remembers; the oldest is forgotten first."""

NOBODY = -1
NOWHERE = -1


@checked
@dataclass(frozen=True, slots=True)
class Beliefs:
    """What each robot believes, in its own frame: it starts at the origin, looking along x."""

    pose: Float64[Array, "rows 3"]
    """Dead-reckoned x, y [m] and heading [rad]."""

    location: Float64[Array, "rows areas 2"]
    """Believed centre of each area [m]."""

    p: Float64[Array, "rows areas"]
    """Path travelled since each area [m]: the inverse of the confidence."""

    known: Bool[Array, "rows areas"]
    """The robot believes it knows where the area is."""

    on_area: Int8[Array, " rows"]
    """The area under the robot, NOWHERE on the floor."""

    came_from: Int8[Array, " rows"]
    """The area visited last, NOWHERE after getting lost."""

    goal: Int8[Array, " rows"]
    """The area to go to, NOWHERE to wander."""

    look_on: Float64[Array, " rows"]
    """At the place where the area should be: path left to look for it straight on [m]; -1
    while still on the way."""

    deaf: Int32[Array, " rows"]
    """Ticks for which messages are still ignored, after getting lost or after an exchange."""

    lost: Bool[Array, " rows"]
    """The robot found itself lost in this tick."""

    partner: Int32[Array, " rows"]
    """The robot in conversation with, NOBODY when alone."""

    talk_left: Int32[Array, " rows"]
    """Ticks until the conversation ends."""

    heard_sum: Float64[Array, "rows areas 2"]
    """Sum over the conversation of the heard locations, own frame, weighted by frames [m]."""

    heard_weight: Float64[Array, "rows areas"]
    """Frames that told of each area in this conversation."""

    heard_p: Float64[Array, "rows areas"]
    """The partner's p of each area as told last [m]."""

    range_sum: Float64[Array, " rows"]
    """Sum over the conversation of the measured range, weighted by frames [m]."""

    frames: Float64[Array, " rows"]
    """Frames heard in this conversation."""

    met: Int32[Array, "rows memory"]
    """Partners of the last conversations, NOBODY where there was none."""

    met_for: Int32[Array, "rows memory"]
    """Ticks for which each of them is still not talked to again."""


def no_beliefs(rows: int) -> Beliefs:
    """Robots that know nothing and have met nobody."""
    return Beliefs(
        pose=np.zeros((rows, 3)),
        location=np.zeros((rows, 2, 2)),
        p=np.zeros((rows, 2)),
        known=np.zeros((rows, 2), np.bool_),
        on_area=np.full(rows, NOWHERE, np.int8),
        came_from=np.full(rows, NOWHERE, np.int8),
        goal=np.full(rows, NOWHERE, np.int8),
        look_on=np.full(rows, -1.0),
        deaf=np.zeros(rows, np.int32),
        lost=np.zeros(rows, np.bool_),
        partner=np.full(rows, NOBODY, np.int32),
        talk_left=np.zeros(rows, np.int32),
        heard_sum=np.zeros((rows, 2, 2)),
        heard_weight=np.zeros((rows, 2)),
        heard_p=np.zeros((rows, 2)),
        range_sum=np.zeros(rows),
        frames=np.zeros(rows),
        met=np.full((rows, MEMORY), NOBODY, np.int32),
        met_for=np.zeros((rows, MEMORY), np.int32),
    )


def forget(beliefs: Beliefs, world: int, n_robots: int) -> None:
    """Put one world's robots back to knowing nothing, in place."""
    rows = slice(world * n_robots, (world + 1) * n_robots)
    fresh = no_beliefs(n_robots)
    for field in fields(Beliefs):
        getattr(beliefs, field.name)[rows] = getattr(fresh, field.name)
