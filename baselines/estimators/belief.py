"""Records of social odometry: the belief of a robot, its message, and its present exchange."""

import numpy as np

from swarm_forage_env.arrays import Array, Float32, Float64, Int8, Int32
from swarm_forage_env.foraging.records import Exchange, Situation
from swarm_forage_env.record import Record, field

MEMORY = 8  # recent partners that a robot remembers; the oldest is overwritten first

NOBODY = -1
NOWHERE = -1


class Message(Record):
    """Message of a robot: its estimate of each area. Writer: `compose`."""

    has_estimate: Int8[Array, " areas"] = field(np.int8, 2)
    """Whether the message contains an estimate of the area."""
    distance: Float32[Array, " areas"] = field(np.float32, 2, unit="m")
    """Distance from the sender to the area."""
    direction: Float32[Array, " areas"] = field(np.float32, 2, unit="rad")
    """Direction of the area in the body frame of the sender."""
    p: Float32[Array, " areas"] = field(np.float32, 2, unit="m")
    """p of the sender: the inverse of its confidence."""


class Belief(Record):
    """Belief of a robot, in its own frame: the robot starts at the origin, heading along x."""

    pose: Float64[Array, "3"] = field(np.float64, 3, unit="m, m, rad")
    """Dead-reckoned x, y [m] and heading [rad]."""
    location: Float64[Array, "areas 2"] = field(np.float64, 2, 2, unit="m")
    """Believed centre of each area."""
    p: Float64[Array, " areas"] = field(np.float64, 2, unit="m")
    """Path length since each area: the inverse of the confidence."""
    known: Int8[Array, " areas"] = field(np.int8, 2)
    """Whether the robot has an estimate of the area."""
    visited: Int8[Array, " areas"] = field(np.int8, 2)
    """Whether the robot itself has been on the area since it was last lost."""
    on_area: int = field(np.int8, start=NOWHERE)
    """Area under the robot; NOWHERE between the areas."""
    came_from: int = field(np.int8, start=NOWHERE)
    """Area visited last; NOWHERE after a loss."""
    goal: int = field(np.int8, start=NOWHERE)
    """Area to drive to; NOWHERE for a random walk."""
    search_path_left: float = field(np.float64, unit="m", start=-1.0)
    """Path left of the straight search at the goal's believed location; -1 before the search."""
    ignore_ticks: int = field(np.int32, unit="ticks")
    """Ticks for which the robot still ignores messages, after a loss or an exchange."""
    is_lost: bool = field(np.bool_)
    """Whether the robot got lost in this tick."""
    partner: int = field(np.int32, start=NOBODY)
    """Partner of the present exchange; NOBODY without an exchange."""
    last_partner: int = field(np.int32, start=NOBODY)
    """Partner of the present exchange or, without one, of the last exchange."""
    exchange_ticks_left: int = field(np.int32, unit="ticks")
    """Ticks until the exchange ends."""
    heard_sum: Float64[Array, "areas 2"] = field(np.float64, 2, 2, unit="m")
    """Sum of the heard locations over the exchange, own frame, weighted by frames."""
    heard_weight: Float64[Array, " areas"] = field(np.float64, 2, unit="frames")
    """Frames with an estimate of each area in this exchange."""
    heard_p: Float64[Array, " areas"] = field(np.float64, 2, unit="m")
    """Last heard p of each area, plus `message_path`."""
    range_sum: float = field(np.float64, unit="m")
    """Sum of the measured range over the exchange, weighted by frames."""
    n_averaged: float = field(np.float64, unit="frames")
    """Frames heard in this exchange."""
    recent_partners: Int32[Array, " memory"] = field(np.int32, MEMORY, start=NOBODY)
    """Partners of the last exchanges; NOBODY in unused entries."""
    recent_ticks_left: Int32[Array, " memory"] = field(np.int32, MEMORY, unit="ticks")
    """Ticks until an exchange with each of these partners may start again."""


class SocialMind(Record):
    """State of a robot under social odometry."""

    belief: Belief = field(Belief)
    message: Message = field(Message)
    is_heard: bool = field(np.bool_)
    """Whether a robot listens, so that the message must be composed. Writer: observe."""
    is_composed: bool = field(np.bool_)
    """Whether the message is of this tick; it is composed only if a robot listens."""
    stale_message: Message = field(Message)
    """Message that a stale robot repeats. Writer: `repeat`."""
    stale_pose: Float64[Array, "3"] = field(np.float64, 3, unit="m, m, rad")
    """Believed pose at which the stale message was composed."""
    has_stale_message: bool = field(np.bool_)
    """Whether `stale_message` holds one."""
    exchange: Exchange = field(Exchange)
    situation: Situation = field(Situation)
