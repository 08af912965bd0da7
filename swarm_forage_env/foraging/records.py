"""Records of foraging: additions to those of e-pucks, and the inputs and outputs of layers.

The inputs of layers have the memory layout described in `epuck.records`. On an axis of length 2 for
areas, 0 is the nest and 1 the prey area.
"""

from typing import Any

import numpy as np

from swarm_forage_env.arrays import Array, Float32, Float64, Int8, Int64
from swarm_forage_env.epuck.records import AREAS, SPEED, EpuckState, EpuckWorldState, range_noise
from swarm_forage_env.equations.ground import FLOOR
from swarm_forage_env.foraging.areas import MAX_AREAS
from swarm_forage_env.record import Record, field, flag
from swarm_forage_env.spaces import GOALS

WORDS = 12
"""Number of values in a message of a learner of everything."""

PLACE: dict[str, Any] = {"unit": "m", "scale": 1.0}
PATH: dict[str, Any] = {"unit": "m", "scale": 2.0, "low": 0.0}
"""Keywords of fields for a path: the path to an area, and p."""


def goal_field() -> Any:  # noqa: ANN401 as `field`
    """Return a field for the goal of a robot, in one-hot form with three elements."""
    return field(
        np.float32, 3, unit="0 or 1", low=0.0, high=1.0, names=(GOALS,), start=(0.0, 0.0, 1.0)
    )


class WorldState(EpuckWorldState):
    """World of foraging e-pucks: its areas, in addition to the fields of `EpuckWorldState`."""

    half_time: int = field(np.int64)
    """Number of ticks in the first half of an episode."""
    areas: Float64[Array, "8 2"] = field(np.float64, MAX_AREAS, 2, unit="m")
    """Current centres of the areas: the first nest, the first prey area, then all others.
    Writers: reset, tick."""
    kinds: Int8[Array, "8"] = field(np.int8, MAX_AREAS, start=FLOOR)
    """Kind of each area, NEST or PREY; FLOOR from `n_areas` on."""
    n_areas: int = field(np.int64)
    worths: Float64[Array, "8"] = field(np.float64, MAX_AREAS)
    moves_at: Int64[Array, "8"] = field(np.int64, MAX_AREAS, unit="ticks")
    """Tick at which each area moves to `moves_to`; NEVER if it does not."""
    moves_to: Float64[Array, "8 2"] = field(np.float64, MAX_AREAS, 2, unit="m")
    first_places: Float64[Array, "8 2"] = field(np.float64, MAX_AREAS, 2, unit="m")
    """Centres of the areas at the start."""
    area_radius: float = field(np.float64, unit="m")


class Report(Record):
    """Report of a controller to the experimenter, not to the swarm. Writer: observe."""

    is_lost: bool = field(np.bool_)
    """Whether the robot has just got lost."""
    known: Int8[Array, " areas"] = field(np.int8, 2)
    """Whether the robot believes that it knows the place of the area."""


class RobotState(EpuckState):
    """State of one foraging e-puck: its trips, in addition to the fields of `EpuckState`."""

    leg: int = field(np.int8)
    """Leg: 0 before the first nest; 1 to the prey; 2 back to the nest. Writer: tick."""
    load: float = field(np.float32)
    """Worth of the prey area of the item that the robot carries. Writer: tick."""
    round_trips: int = field(np.int32)
    """Number of completed trips nest -> prey -> nest. Writer: tick."""
    first_visit: Int64[Array, " areas"] = field(np.int64, 2, unit="ticks", start=-1)
    """Tick of the first visit to each area, -1 before it. Writer: tick."""
    known: Int8[Array, " areas"] = field(np.int8, 2)
    """Whether the robot reported before the last tick that it knows the area. Writer: tick."""
    path_ticks: int = field(np.int64, unit="ticks")
    """Number of ticks in the episode's second half with both areas known. Writer: tick."""
    lost_events: int = field(np.int32)
    """Number of times that the robot reported itself lost. Writer: tick."""
    report: Report = field(Report)


class Exchange(Record):
    """Inputs of the weighting layer: the exchange that ended in this tick; zeros without one."""

    is_valid: float = flag(label="valid")
    """Whether an exchange ended in this tick."""
    own_p: Float32[Array, " areas"] = field(np.float32, 2, names=(AREAS,), **PATH)
    """Own inverse confidence: path since leaving the area; 0 if unknown."""
    heard_p: Float32[Array, " areas"] = field(np.float32, 2, names=(AREAS,), **PATH)
    """Inverse confidence received from the partner; 0 if it sent none."""
    own_known: Float32[Array, " areas"] = flag(2, names=(AREAS,))
    """Whether the robot knows the place of the area."""
    heard_known: Float32[Array, " areas"] = flag(2, names=(AREAS,))
    """Whether the partner sent the place of the area."""
    disagreement: Float32[Array, " areas"] = field(
        np.float32, 2, unit="m", scale=0.5, low=0.0, names=(AREAS,)
    )
    """Distance between the own and the received location, if both are known."""
    own_distance: Float32[Array, " areas"] = field(np.float32, 2, low=0.0, names=(AREAS,), **PLACE)
    """Distance of the robot from the own location; zero if unknown."""
    heard_distance: Float32[Array, " areas"] = field(
        np.float32, 2, low=0.0, names=(AREAS,), **PLACE
    )
    """Distance of the robot from the received location; zero if unknown."""
    range: float = field(np.float32, unit="m", scale=0.1, low=0.0, noise=range_noise)
    """Measured distance to the partner, averaged."""
    n_averaged: float = field(np.float32, unit="frames", scale=8.0, low=0.0, label="frames")
    """Number of frames averaged in this exchange."""
    goal: Float32[Array, "3"] = goal_field()
    """Area that the robot is heading for, in one-hot form: nest, prey, none."""
    right: float = field(np.float32)
    """Number of times that the partner's messages proved right. This and the next four fields are
    zero with an estimator that keeps no reputations, and a learner does not observe them."""
    wrong: float = field(np.float32)
    """Number of times that the partner's messages proved wrong."""
    support: Float32[Array, " areas"] = field(np.float32, 2)
    """Number of other robots that recently sent the same place, weighted by the trust in each."""
    suspicion: Float32[Array, " areas"] = field(np.float32, 2)
    """Number of the robots of `support`, weighted by the distrust in each."""
    dissent: Float32[Array, " areas"] = field(np.float32, 2)
    """Number of other robots that recently sent another place, weighted by the trust in each."""
    own_visited: Float32[Array, " areas"] = field(np.float32, 2)
    """Whether the robot has been on the area since it last got lost."""
    weight: Float32[Array, " areas"] = field(np.float32, 2)
    """Weight of the last merge of received estimates. Writer: decide."""


class Situation(Record):
    """Inputs of the motion layer: the robot's beliefs. Writer: observe."""

    target: Float32[Array, "2"] = field(np.float32, 2, names=("xy",), **PLACE)
    """Position of the goal, body frame; zeros without a goal."""
    areas: Float32[Array, "areas 2"] = field(np.float32, 2, 2, names=(AREAS, "xy"), **PLACE)
    """Believed centres of nest and prey, body frame; zeros if unknown."""
    p: Float32[Array, " areas"] = field(np.float32, 2, names=(AREAS,), **PATH)
    """Own inverse confidence; zero if unknown."""
    known: Float32[Array, " areas"] = flag(2, names=(AREAS,))
    """Whether the robot believes that it knows the place of the area."""
    goal: Float32[Array, "3"] = goal_field()
    """Area that the robot is heading for, in one-hot form: nest, prey, none."""
    is_talking: float = flag(label="talking")
    """Whether an exchange is under way; readings are better while the robot stands still."""
    walk: Float32[Array, "2"] = field(
        np.float32, 2, unit="ratio", names=("xy",), start=(1.0, 0.0), **SPEED
    )
    """Unit vector of the course of the robot's random walk, body frame, by its own odometry, also
    while a learner steers. Straight ahead for a motion without a walk. Writer: decide."""


class PolicyMessages(Record):
    """Messages that a learner of everything sends and receives."""

    speak: float = field(np.float32, unit="broadcast if > 0", **SPEED)
    """Whether the message is broadcast. Writer: the environment."""
    words: Float32[Array, " words"] = field(np.float32, WORDS, unit="as sent", **SPEED)
    """Message to be sent; its meaning is up to the policy. Writer: the environment."""
    heard: Float32[Array, "slots words"] = field(
        np.float32, "slots", WORDS, unit="as sent", label="words", **SPEED
    )
    """Received message in each slot; zeros in empty slots. Writer: observe."""
