"""Records of faults: the faults of a robot, and the lie of a liar.

No layer and no observation contains them. An estimator receives only a `Lie`, to put it into the
message that it composed.
"""

import numpy as np

from swarm_forage_env.arrays import Array, Float32, Float64, Int8, Int32, UInt64
from swarm_forage_env.record import Record, field

KINDS = ("dead", "worn", "deaf", "mute", "blind", "liar", "stale")
"""Kinds of faults, by their names in a scenario."""

DEAD, WORN, DEAF, MUTE, BLIND, LIAR, STALE = range(len(KINDS))

N_KINDS = len(KINDS)


NOT_AGREED, TURN_AGREED, PLACE_AGREED = range(3)
"""Agreement among liars: none, the turn and shift of a place, or the place itself."""


class FaultNumbers(Record):
    """Fault parameters of a scenario in the form that kernels read."""

    share: Float64[Array, " kinds"] = field(np.float64, N_KINDS)
    """Share of the robots that are drawn to have each fault, in the order of KINDS."""
    starts: Int32[Array, " kinds"] = field(np.int32, N_KINDS, unit="ticks")
    """Tick at the end of which each fault takes effect."""
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
    """Lie about each area, which is sent instead of the belief."""

    turn: float = field(np.float32, unit="rad")
    """Angle by which the place sent is rotated about the liar."""
    place: Float32[Array, "areas 2"] = field(np.float32, 2, 2, unit="m")
    """Shift of the place sent, or the place itself, in the body frame. Writer: tick."""
    is_place: bool = field(np.bool_)
    """Whether `place` is sent as it is instead of a shift of the belief."""
    p: float = field(np.float32, unit="m")
    """Inverse confidence that is sent."""
    has_own_p: bool = field(np.bool_)
    """Whether the robot's own p is sent instead of `p`."""


class Fault(Record):
    """Present and future faults of a robot; read and written only if a scenario has faults.

    It is separate from `EpuckState`, which holds the faults in effect, so that robots without
    faults need less memory.
    """

    is_named: Int8[Array, " kinds"] = field(np.int8, N_KINDS)
    """Whether the scenario assigns each fault, independent of draws. Writer: the scenario."""
    kinds: Int8[Array, " kinds"] = field(np.int8, N_KINDS)
    """Whether the robot has or will have each fault, in the order of KINDS. Writer: reset."""
    path_misread: Float32[Array, "2"] = field(np.float32, 2)
    """Worn: reading of the left and right wheel encoder, as a share of the true path.
    Writer: reset."""
    lie: Lie = field(Lie)
    """Content of the robot's lies. Writers: reset, tick."""
    lie_in_arena: Float32[Array, "areas 2"] = field(np.float32, 2, 2, unit="m")
    """Shift or place of the lie, world frame. Writer: reset."""
    stream: UInt64[Array, "1"] = field(np.uint64, 1)
    """Random stream of the faults. Writers: reset, observe."""
