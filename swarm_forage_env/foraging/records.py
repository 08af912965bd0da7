"""Records of the foraging world: the world, the robot, and what crosses a layer's border.

What layers see is float32 in SI units, flags among it as 0 or 1, and lies in memory as an
environment shows it in its observation: a policy in the place of a layer sees what the
hand-written layer sees. Its typical sizes are the same in all scenarios, so that a policy can go
from one to another.
On an axis of length 2 that counts areas, 0 is the nest and 1 the prey area.
"""

import math
from typing import Any

import numpy as np

from swarm_forage_env.arrays import Array, Float32, Float64, Int8, Int32, Int64, UInt64
from swarm_forage_env.equations.ground import FLOOR
from swarm_forage_env.foraging.areas import MOST_AREAS
from swarm_forage_env.foraging.fault_record import Fault
from swarm_forage_env.foraging.limits import (
    bearing_noise,
    ground_noise,
    max_brightness,
    max_step,
    max_turn,
    odometry_noise,
    proximity_noise,
    range_noise,
)
from swarm_forage_env.record import Record, field, flag
from swarm_forage_env.spaces import GOALS

AREAS = ("nest", "prey")
WHEELS = ("left", "right")

WORDS = 12
"""Numbers in a message of a learner of everything."""

PLACE: dict[str, Any] = {"unit": "m", "scale": 1.0}
PATH: dict[str, Any] = {"unit": "m", "scale": 2.0, "low": 0.0}
"""The way to an area, and p."""

SPEED: dict[str, Any] = {"low": -1.0, "high": 1.0}

ENCODER, PROXIMITY, GROUND, LOSS, SLOT, RADIO = range(6)
"""Columns of a robot's random streams."""


def goal_field() -> Any:  # noqa: ANN401 as `field`
    """A field that says where a robot is heading: one of three numbers is 1."""
    return field(
        np.float32, 3, unit="0 or 1", low=0.0, high=1.0, names=(GOALS,), start=(0.0, 0.0, 1.0)
    )


class WorldState(Record):
    """One world: its clock, and the numbers of its scenario as kernels read them."""

    ticks: int = field(np.int64)
    """Ticks since reset. Writer: tick."""

    has_moved: bool = field(np.bool_)
    """The engine has moved the robots already in this tick. Writers: the engine, tick."""

    half_time: int = field(np.int64)
    """Ticks in the first half of an episode."""

    dt: float = field(np.float64, unit="s")
    arena: Float64[Array, "2"] = field(np.float64, 2, unit="m")
    areas: Float64[Array, "8 2"] = field(np.float64, MOST_AREAS, 2, unit="m")
    """Centres of the areas as they are now: the first nest, the first prey area, then all others.
    Writers: reset, tick."""

    kinds: Int8[Array, "8"] = field(np.int8, MOST_AREAS, start=FLOOR)
    """NEST or PREY; FLOOR from `n_areas` on."""

    n_areas: int = field(np.int64)
    worths: Float64[Array, "8"] = field(np.float64, MOST_AREAS)
    moves_at: Int64[Array, "8"] = field(np.int64, MOST_AREAS, unit="ticks")
    """When an area moves to `moves_to`; NEVER if it stays."""

    moves_to: Float64[Array, "8 2"] = field(np.float64, MOST_AREAS, 2, unit="m")
    first_places: Float64[Array, "8 2"] = field(np.float64, MOST_AREAS, 2, unit="m")
    """Centres of the areas at the start."""

    area_radius: float = field(np.float64, unit="m")
    start_radius: float = field(np.float64, unit="m")
    radius: float = field(np.float64, unit="m")
    axle: float = field(np.float64, unit="m")
    max_speed: float = field(np.float64, unit="m/s")
    cruise_speed: float = field(np.float64, unit="m/s")
    encoder_error: float = field(np.float64, unit="m")
    proximity_noise: float = field(np.float64)
    ground_noise: float = field(np.float64)
    ground_ahead: float = field(np.float64, unit="m")
    ground_spacing: float = field(np.float64, unit="m")

    max_range: float = field(np.float64, unit="m")
    near: float = field(np.float64, unit="m")
    loss_near: float = field(np.float64)
    loss_far: float = field(np.float64)
    range_noise: float = field(np.float64, unit="m")
    bearing_noise: float = field(np.float64, unit="rad")
    is_board: bool = field(np.bool_)
    frames: int = field(np.int64)
    slots: int = field(np.int64)

    reach: float = field(np.float64, unit="m")
    """Robots within this of each other are listed as neighbours, centre to centre."""

    n_obstacles: int = field(np.int64)
    """Capsules in this world's row of `obstacles`; the rest of the row is padding."""

    is_shadowed: bool = field(np.bool_)
    """An obstacle between two robots keeps their messages from each other."""

    has_faults: bool = field(np.bool_)
    """Some robots may be faulty."""

    is_crowded: bool = field(np.bool_)
    """Robots overlap or obstacles stand, so that contacts are to be resolved; false between ticks.
    Writer: tick."""


class Readings(Record):
    """What the robot's own sensors say after a tick. Writer: tick."""

    proximity: Float32[Array, "8"] = field(
        np.float32, 8, unit="reading", low=0.0, high=1.0, noise=proximity_noise
    )
    """Infrared, 1 at contact and 0 beyond 5 cm, at PROXIMITY_ANGLES of the body frame."""

    ground: Float32[Array, "3"] = field(
        np.float32,
        3,
        unit="brightness",
        low=0.0,
        high=max_brightness,
        names=(("left", "middle", "right"),),
        noise=ground_noise,
    )
    """Brightness under the left, middle and right ground sensor: nest 0, prey 0.5, floor 1."""

    odometry: Float32[Array, "2"] = field(
        np.float32,
        2,
        unit="m, rad",
        low=(lambda scenario: -max_step(scenario), lambda scenario: -max_turn(scenario)),
        high=(max_step, max_turn),
        names=(("distance", "turn"),),
        noise=odometry_noise,
    )
    """Distance [m] and turn [rad] since the last tick, as the wheel encoders tell them."""


class Heard(Record):
    """The messages that reach a robot in a tick; slots from `n` on are zeros. Writer: tick."""

    is_valid: Float32[Array, " slots"] = flag("slots", label="valid")
    """The slot holds a message."""

    range_bearing: Float32[Array, "slots 3"] = field(
        np.float32,
        "slots",
        3,
        unit="m, rad, rad",
        scale=(0.1, None, None),
        low=(0.0, -math.pi, -math.pi),
        high=(math.inf, math.pi, math.pi),
        names=(("range", "bearing", "bearing_back"),),
        label="beam",
        noise=(range_noise, bearing_noise, bearing_noise),
    )
    """Range of the sender [m], its bearing in the body frame of the receiver [rad], and the
    bearing of the receiver in the body frame of the sender [rad], as measured."""

    n_averaged: Float32[Array, " slots"] = field(
        np.float32,
        "slots",
        unit="frames",
        low=0.0,
        high=lambda scenario: float(scenario.radio.frames),
        label="frames",
    )
    """Frames averaged into the measurement: several while the receiver stands still."""

    n: int = field(np.int32, counts="is_valid")
    """Messages heard."""

    sender: Int32[Array, " slots"] = field(np.int32, "slots")
    """Which robot of the same world sent it: 0 .. N - 1; stale from `n` on."""


class Command(Record):
    """What a controller tells a robot to do in the next tick. Writer: decide."""

    wheels: Float32[Array, "2"] = field(
        np.float32, 2, unit="of cruise speed", names=(WHEELS,), **SPEED
    )
    """Speed of the left and right wheel; the motors reach robot.max_speed at most."""

    is_speaking: bool = field(np.bool_)
    """The robot broadcasts its message."""


class Report(Record):
    """What a controller reports to the experimenter, not to the swarm. Writer: observe."""

    is_lost: bool = field(np.bool_)
    """The robot just found itself lost."""

    known: Int8[Array, " areas"] = field(np.int8, 2)
    """The robot believes it knows where the area is."""


class Action(Record):
    """What a learner does with the layers of one robot. Writer: the environment."""

    weighting: int = field(np.int8)
    """KEEP or REPLACE the hand-written weighting."""

    motion: int = field(np.int8)
    """KEEP, REPLACE or CORRECT the hand-written motion."""

    weight: Float32[Array, " areas"] = field(
        np.float32, 2, unit="weight", low=0.0, high=1.0, names=(AREAS,), label="g"
    )
    """Weight in [0, 1] of what was heard about each area; of no effect where no exchange just
    ended."""

    wheels: Float32[Array, "2"] = field(
        np.float32, 2, unit="of cruise speed", names=(WHEELS,), **SPEED
    )
    """Speed of the left and right wheel, or what is added to it."""


class RobotState(Record):
    """The truth about one robot, and what it senses, does and reports."""

    pose: Float64[Array, "3"] = field(np.float64, 3, unit="m, m, rad")
    """x, y [m] and heading [rad] in the world frame. Writers: engine, tick; reset."""

    heading: Float64[Array, "2"] = field(np.float64, 2)
    """Cosine and sine of the heading. Writer: tick."""

    wheels: Float64[Array, "2"] = field(np.float64, 2, unit="m/s")
    """Speed of the left and right wheel in the last tick. Writers: engine, tick."""

    streams: UInt64[Array, "6"] = field(np.uint64, 6)
    """Random streams: ENCODER, PROXIMITY, GROUND, LOSS, SLOT, RADIO. Writer: tick."""

    rays: Float64[Array, "8"] = field(np.float64, 8, unit="m", start=np.inf)
    """Length of each infrared ray from the rim; infinite beyond its reach. Writer: tick."""

    leg: int = field(np.int8)
    """0: nest not yet visited; 1: on the way to the prey; 2: on the way back. Writer: tick."""

    load: float = field(np.float32)
    """Worth of the prey area that the robot brings an item from. Writer: tick."""

    reward: float = field(np.float32)
    """What the round trip that was completed in the last tick is worth, or 0. Writer: tick."""

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

    messages: int = field(np.int32)
    """Messages heard. Writer: tick."""

    readings: Readings = field(Readings)
    heard: Heard = field(Heard)
    command: Command = field(Command)
    report: Report = field(Report)
    action: Action = field(Action)

    fault: Fault = field(Fault)
    """What is wrong with it. Writers: reset, tick."""


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


class Said(Record):
    """What a learner of everything says and is told."""

    speak: float = field(np.float32, unit="broadcast if > 0", **SPEED)
    """Whether the message is broadcast. Writer: the environment."""

    words: Float32[Array, " words"] = field(np.float32, WORDS, unit="as sent", **SPEED)
    """The message, whose meaning is the policy's. Writer: the environment."""

    heard: Float32[Array, "slots words"] = field(
        np.float32, "slots", WORDS, unit="as sent", label="words", **SPEED
    )
    """The message in each slot; zeros in an empty one. Writer: observe."""
