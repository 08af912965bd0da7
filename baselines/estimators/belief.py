"""Records of social odometry: what a robot believes, what it tells, and what it is being told."""

import numpy as np

from swarm_forage_env.arrays import Array, Float32, Float64, Int8, Int32
from swarm_forage_env.foraging.records import Exchange, Situation
from swarm_forage_env.record import Record, field

MEMORY = 8  # recent partners a robot remembers; the oldest is forgotten first

NOBODY = -1
NOWHERE = -1


class Message(Record):
    """What a robot tells of each area. Writer: `compose`."""

    told: Int8[Array, " areas"] = field(np.int8, 2)
    """The message tells where the area is."""
    distance: Float32[Array, " areas"] = field(np.float32, 2, unit="m")
    """From the sender to the area."""
    direction: Float32[Array, " areas"] = field(np.float32, 2, unit="rad")
    """Of the area in the body frame of the sender."""
    p: Float32[Array, " areas"] = field(np.float32, 2, unit="m")
    """The sender's inverse confidence."""


class Belief(Record):
    """What a robot believes, in its own frame: it starts at the origin, looking along x."""

    pose: Float64[Array, "3"] = field(np.float64, 3, unit="m, m, rad")
    """Dead-reckoned x, y [m] and heading [rad]."""
    location: Float64[Array, "areas 2"] = field(np.float64, 2, 2, unit="m")
    """Believed centre of each area."""
    p: Float64[Array, " areas"] = field(np.float64, 2, unit="m")
    """Path travelled since each area: the inverse of the confidence."""
    known: Int8[Array, " areas"] = field(np.int8, 2)
    """The robot believes it knows where the area is."""
    visited: Int8[Array, " areas"] = field(np.int8, 2)
    """The robot stood on the area itself since it was last lost."""
    on_area: int = field(np.int8, start=NOWHERE)
    """The area under the robot, NOWHERE on the floor."""
    came_from: int = field(np.int8, start=NOWHERE)
    """The area visited last, NOWHERE after getting lost."""
    goal: int = field(np.int8, start=NOWHERE)
    """The area to go to, NOWHERE to wander."""
    search_path_left: float = field(np.float64, unit="m", start=-1.0)
    """At the place where the area should be: path left to look for it straight on; -1 while
    still on the way."""
    ignore_ticks: int = field(np.int32, unit="ticks")
    """Ticks for which messages are still ignored, after getting lost or after an exchange."""
    is_lost: bool = field(np.bool_)
    """The robot found itself lost in this tick."""
    partner: int = field(np.int32, start=NOBODY)
    """The robot in an exchange with, NOBODY when alone."""
    last_partner: int = field(np.int32, start=NOBODY)
    """The robot that the present exchange is with, or the last one was."""
    exchange_ticks_left: int = field(np.int32, unit="ticks")
    """Ticks until the exchange ends."""
    heard_sum: Float64[Array, "areas 2"] = field(np.float64, 2, 2, unit="m")
    """Sum over the exchange of the heard locations, own frame, weighted by frames."""
    heard_weight: Float64[Array, " areas"] = field(np.float64, 2, unit="frames")
    """Frames that told of each area in this exchange."""
    heard_p: Float64[Array, " areas"] = field(np.float64, 2, unit="m")
    """The partner's p of each area as told last."""
    range_sum: float = field(np.float64, unit="m")
    """Sum over the exchange of the measured range, weighted by frames."""
    n_averaged: float = field(np.float64, unit="frames")
    """Frames heard in this exchange."""
    met: Int32[Array, " memory"] = field(np.int32, MEMORY, start=NOBODY)
    """Partners of the last exchanges, NOBODY where there was none."""
    met_ticks_left: Int32[Array, " memory"] = field(np.int32, MEMORY, unit="ticks")
    """Ticks for which each of them is still not talked to again."""


class SocialMind(Record):
    """All that social odometry keeps of a robot."""

    belief: Belief = field(Belief)
    message: Message = field(Message)
    is_heard: bool = field(np.bool_)
    """Somebody listens to its message, which is to be composed. Writer: observe."""
    is_composed: bool = field(np.bool_)
    """The message is that of this tick: it is composed only when somebody listens."""
    kept: Message = field(Message)
    """Of a stale robot: the message that it repeats. Writer: `repeat`."""
    kept_pose: Float64[Array, "3"] = field(np.float64, 3, unit="m, m, rad")
    """The believed pose in which it was told first."""
    is_kept: bool = field(np.bool_)
    """There is one."""
    exchange: Exchange = field(Exchange)
    situation: Situation = field(Situation)
