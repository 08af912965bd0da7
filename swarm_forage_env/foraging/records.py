"""Records of the foraging world: what foraging adds to e-pucks, and what crosses a layer's border.

What layers see lies in memory as `epuck.records` says. On an axis of length 2 that counts areas, 0
is the nest and 1 the prey area.
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
"""Numbers in a message of a learner of everything."""

PLACE: dict[str, Any] = {"unit": "m", "scale": 1.0}
PATH: dict[str, Any] = {"unit": "m", "scale": 2.0, "low": 0.0}
"""The way to an area, and p."""


def goal_field() -> Any:  # noqa: ANN401 as `field`
    """A field that says where a robot is heading: one of three numbers is 1."""
    return field(
        np.float32, 3, unit="0 or 1", low=0.0, high=1.0, names=(GOALS,), start=(0.0, 0.0, 1.0)
    )


class WorldState(EpuckWorldState):
    """One world in which e-pucks forage: its areas beside all that the robots need."""

    half_time: int = field(np.int64)
    """Ticks in the first half of an episode."""
    areas: Float64[Array, "8 2"] = field(np.float64, MAX_AREAS, 2, unit="m")
    """Centres of the areas as they are now: the first nest, the first prey area, then all others.
    Writers: reset, tick."""
    kinds: Int8[Array, "8"] = field(np.int8, MAX_AREAS, start=FLOOR)
    """NEST or PREY; FLOOR from `n_areas` on."""
    n_areas: int = field(np.int64)
    worths: Float64[Array, "8"] = field(np.float64, MAX_AREAS)
    moves_at: Int64[Array, "8"] = field(np.int64, MAX_AREAS, unit="ticks")
    """When an area moves to `moves_to`; NEVER if it stays."""
    moves_to: Float64[Array, "8 2"] = field(np.float64, MAX_AREAS, 2, unit="m")
    first_places: Float64[Array, "8 2"] = field(np.float64, MAX_AREAS, 2, unit="m")
    """Centres of the areas at the start."""
    area_radius: float = field(np.float64, unit="m")


class Report(Record):
    """What a controller reports to the experimenter, not to the swarm. Writer: observe."""

    is_lost: bool = field(np.bool_)
    """The robot just found itself lost."""
    known: Int8[Array, " areas"] = field(np.int8, 2)
    """The robot believes it knows where the area is."""


class RobotState(EpuckState):
    """The truth about one e-puck that forages: its way beside all that it senses and does."""

    leg: int = field(np.int8)
    """0: nest not yet visited; 1: on the way to the prey; 2: on the way back. Writer: tick."""
    load: float = field(np.float32)
    """Worth of the prey area that the robot brings an item from. Writer: tick."""
    round_trips: int = field(np.int32)
    """Completed trips nest -> prey -> nest. Writer: tick."""
    first_visit: Int64[Array, " areas"] = field(np.int64, 2, unit="ticks", start=-1)
    """Tick of the first visit to each area, -1 before it. Writer: tick."""
    known: Int8[Array, " areas"] = field(np.int8, 2)
    """The robot reported before the last tick that it knows where the area is. Writer: tick."""
    path_ticks: int = field(np.int64, unit="ticks")
    """Ticks in the second half of the episode in which both areas were known. Writer: tick."""
    lost_events: int = field(np.int32)
    """How often the robot reported itself lost. Writer: tick."""
    report: Report = field(Report)


class Exchange(Record):
    """What the weighting layer sees of an exchange that ended in this tick; zeros without one."""

    is_valid: float = flag(label="valid")
    """An exchange ended in this tick."""
    own_p: Float32[Array, " areas"] = field(np.float32, 2, names=(AREAS,), **PATH)
    """Own inverse confidence: path since leaving the area; 0 where unknown."""
    heard_p: Float32[Array, " areas"] = field(np.float32, 2, names=(AREAS,), **PATH)
    """The partner's inverse confidence; 0 where it told nothing."""
    own_known: Float32[Array, " areas"] = flag(2, names=(AREAS,))
    """The robot knows where the area is."""
    heard_known: Float32[Array, " areas"] = flag(2, names=(AREAS,))
    """The partner told where the area is."""
    disagreement: Float32[Array, " areas"] = field(
        np.float32, 2, unit="m", scale=0.5, low=0.0, names=(AREAS,)
    )
    """Distance between the own and the heard location, where both are known."""
    own_distance: Float32[Array, " areas"] = field(np.float32, 2, low=0.0, names=(AREAS,), **PLACE)
    """How far the robot is from the own location; zero where unknown."""
    heard_distance: Float32[Array, " areas"] = field(
        np.float32, 2, low=0.0, names=(AREAS,), **PLACE
    )
    """How far the robot is from the heard location; zero where unknown."""
    range: float = field(np.float32, unit="m", scale=0.1, low=0.0, noise=range_noise)
    """Distance to the partner, averaged."""
    n_averaged: float = field(np.float32, unit="frames", scale=8.0, low=0.0, label="frames")
    """Frames averaged in this exchange."""
    goal: Float32[Array, "3"] = goal_field()
    """The area the robot is heading for, one of three: nest, prey, none."""
    right: float = field(np.float32)
    """How often what the partner told turned out right; as all that a robot remembers of others,
    zero under an estimator that keeps no reputations, and not observed by a learner."""
    wrong: float = field(np.float32)
    """How often it turned out wrong."""
    support: Float32[Array, " areas"] = field(np.float32, 2)
    """How many others told the same lately, each as far as it is trusted."""
    suspicion: Float32[Array, " areas"] = field(np.float32, 2)
    """The same, each as far as it is not trusted."""
    dissent: Float32[Array, " areas"] = field(np.float32, 2)
    """How many others told another place lately, each as far as it is trusted."""
    own_visited: Float32[Array, " areas"] = field(np.float32, 2)
    """The robot stood on the area itself since it was last lost."""
    weight: Float32[Array, " areas"] = field(np.float32, 2)
    """Weight with which what was heard was merged last. Writer: decide."""


class Situation(Record):
    """What the motion layer sees of the robot's beliefs. Writer: observe."""

    target: Float32[Array, "2"] = field(np.float32, 2, names=("xy",), **PLACE)
    """Where to go, body frame; zeros without a goal."""
    areas: Float32[Array, "areas 2"] = field(np.float32, 2, 2, names=(AREAS, "xy"), **PLACE)
    """Believed centres of nest and prey, body frame; zeros where unknown."""
    p: Float32[Array, " areas"] = field(np.float32, 2, names=(AREAS,), **PATH)
    """Own inverse confidence; zeros where unknown."""
    known: Float32[Array, " areas"] = flag(2, names=(AREAS,))
    """The robot believes it knows where the area is."""
    goal: Float32[Array, "3"] = goal_field()
    """The area the robot is heading for, one of three: nest, prey, none."""
    is_talking: float = flag(label="talking")
    """An exchange is under way: standing still makes its readings better."""
    walk: Float32[Array, "2"] = field(
        np.float32, 2, unit="ratio", names=("xy",), start=(1.0, 0.0), **SPEED
    )
    """Unit vector of the course of the robot's random walk, body frame, by its own odometry;
    kept where a learner steers. Straight ahead under a motion that has no walk. Writer: decide."""


class PolicyMessages(Record):
    """Messages that a learner of everything sends and receives."""

    speak: float = field(np.float32, unit="broadcast if > 0", **SPEED)
    """Whether the message is broadcast. Writer: the environment."""
    words: Float32[Array, " words"] = field(np.float32, WORDS, unit="as sent", **SPEED)
    """The message, whose meaning is the policy's. Writer: the environment."""
    heard: Float32[Array, "slots words"] = field(
        np.float32, "slots", WORDS, unit="as sent", label="words", **SPEED
    )
    """The message in each slot; zeros in an empty one. Writer: observe."""
