"""Records of faults: what is wrong with a robot, and what a liar tells.

No layer and no observation is shown any of it. An estimator is handed a `Lie` alone, to put it into
the message that it composed.
"""

import numpy as np

from swarm_forage_env.arrays import Array, Float32, Float64, Int8, Int32, UInt64
from swarm_forage_env.record import Record, field

KINDS = ("dead", "worn", "deaf", "mute", "blind", "liar", "stale")
"""Kinds of faults, as the scenario names them."""

DEAD, WORN, DEAF, MUTE, BLIND, LIAR, STALE = range(len(KINDS))

N_KINDS = len(KINDS)


NOT_AGREED, TURN_AGREED, PLACE_AGREED = range(3)
"""What liars agree on: nothing, how they turn and shift a place, or the place itself."""


class FaultNumbers(Record):
    """The numbers of a scenario's faults, as kernels read them."""

    share: Float64[Array, " kinds"] = field(np.float64, N_KINDS)
    """Share of the robots that are drawn to have this fault, in the order of KINDS."""
    starts: Int32[Array, " kinds"] = field(np.int32, N_KINDS, unit="ticks")
    """Tick from whose end on a fault is in effect."""
    talks_when_dead: bool = field(np.bool_)
    own_p: bool = field(np.bool_)
    agreed: int = field(np.int8)
    bias: float = field(np.float64)
    noise_factor: float = field(np.float32)
    turn: float = field(np.float64, unit="rad")
    shift: float = field(np.float64, unit="m")
    p: float = field(np.float64, unit="m")
    probability: float = field(np.float32)
    false_place_distance: float = field(np.float64, unit="m")
    arena: Float64[Array, "2"] = field(np.float64, 2, unit="m")
    areas: Float64[Array, "areas 2"] = field(np.float64, 2, 2, unit="m")


class Lie(Record):
    """What a liar tells of each area instead of what it believes."""

    turn: float = field(np.float32, unit="rad")
    """The place told is turned by this about the liar."""
    place: Float32[Array, "areas 2"] = field(np.float32, 2, 2, unit="m")
    """Body frame: how far the place told is shifted, or the place itself. Writer: tick."""
    is_place: bool = field(np.bool_)
    """`place` is told as it is, whatever the liar believes."""
    p: float = field(np.float32, unit="m")
    """Inverse confidence that it tells."""
    has_own_p: bool = field(np.bool_)
    """It tells its own p instead."""


class Fault(Record):
    """What is wrong with a robot, or will be; read and written only where a scenario has faults.

    It lies apart from `EpuckState`, which holds the faults in effect, so that robots without faults
    are smaller in memory.
    """

    is_named: Int8[Array, " kinds"] = field(np.int8, N_KINDS)
    """The scenario says so, whatever is drawn. Writer: the scenario."""
    kinds: Int8[Array, " kinds"] = field(np.int8, N_KINDS)
    """The robot has this fault, or will have it, in the order of KINDS. Writer: reset."""
    path_misread: Float32[Array, "2"] = field(np.float32, 2)
    """Worn: what the encoder of the left and right wheel tells, as a share of its true path.
    Writer: reset."""
    lie: Lie = field(Lie)
    """What it tells while it lies. Writers: reset, tick."""
    lie_in_arena: Float32[Array, "areas 2"] = field(np.float32, 2, 2, unit="m")
    """The shift or the place of the lie, world frame. Writer: reset."""
    stream: UInt64[Array, "1"] = field(np.uint64, 1)
    """Random stream, which only faults draw from. Writers: reset, observe."""
