"""Records of e-pucks: the robot, its sensors and radio, and the world that it stands in.

A task adds what it counts by a subclass of `EpuckState` and one of `EpuckWorldState`.

What layers see is float32 in SI units, flags among it as 0 or 1, and lies in memory as an
environment shows it in its observation: a policy that replaces a layer sees what the
hand-written layer sees. Its typical sizes are the same in all scenarios, so that a policy can go
from one to another.
"""

import math
from typing import Any

import numpy as np

from swarm_forage_env.arrays import Array, Float32, Float64, Int8, Int32, UInt64
from swarm_forage_env.epuck.fault_record import N_KINDS, FaultNumbers
from swarm_forage_env.epuck.scenario import EpuckScenario
from swarm_forage_env.record import Record, field, flag

SLACK = 1.01
"""Room for the rounding to float32."""


def max_step(scenario: EpuckScenario) -> float:
    """Path of a wheel in a tick, as its encoder reads it [m]; a worn encoder reads more."""
    robot, noise = scenario.robot, scenario.sensors.wheel_noise
    speed, worn = robot.max_speed, scenario.faults.worn
    if worn.is_any:
        speed, noise = speed * (1.0 + worn.bias), noise * max(worn.noise_factor, 1.0)
    return SLACK * (speed + noise * robot.cruise_speed) * scenario.tick


def max_turn(scenario: EpuckScenario) -> float:
    """Turn in a tick, as the encoders read it [rad]."""
    return 2.0 * max_step(scenario) / scenario.robot.axle


def odometry_noise(scenario: EpuckScenario) -> tuple[str, str]:
    """Error of distance and turn, in words."""
    robot = scenario.robot
    error = scenario.sensors.wheel_noise * robot.cruise_speed * scenario.tick
    return f"+- {error:.3g} m", f"+- {2.0 * error / robot.axle:.3g} rad"


def range_noise(scenario: EpuckScenario) -> str:
    """How badly one frame measures the range, in words."""
    if scenario.radio.is_board:
        return "lognormal, as the real board, each frame"
    return f"+- {scenario.radio.range_noise:g} m, each frame"


def bearing_noise(scenario: EpuckScenario) -> str:
    """How badly one frame measures a bearing, in words."""
    return f"+- {scenario.radio.bearing_noise:.3g} rad, each frame"


AREAS = ("nest", "prey")
WHEELS = ("left", "right")

SPEED: dict[str, Any] = {"low": -1.0, "high": 1.0}

ENCODER, PROXIMITY, GROUND, LOSS, SLOT, RADIO = range(6)
"""Columns of a robot's random streams."""


class EpuckWorldState(Record):
    """A world of e-pucks: its clock, and the numbers of its scenario as kernels read them."""

    ticks: int = field(np.int64)
    """Ticks since reset. Writer: tick."""
    has_moved: bool = field(np.bool_)
    """The engine has moved the robots already in this tick. Writers: the engine, tick."""
    dt: float = field(np.float64, unit="s")
    arena: Float64[Array, "2"] = field(np.float64, 2, unit="m")
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
    full_reception_range: float = field(np.float64, unit="m")
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
    faults: FaultNumbers = field(FaultNumbers)

    is_crowded: bool = field(np.bool_)
    """Robots overlap or obstacles stand, so that contacts are to be resolved; false between ticks.
    Writer: tick."""


class Readings(Record):
    """What the robot's own sensors say after a tick. Writer: tick."""

    proximity: Float32[Array, "8"] = field(
        np.float32,
        8,
        unit="reading",
        low=0.0,
        high=1.0,
        noise=lambda scenario: f"x (1 +- {scenario.sensors.proximity_noise:g})",
    )
    """Infrared, 1 at contact and 0 beyond 5 cm, at PROXIMITY_ANGLES of the body frame."""
    ground: Float32[Array, "3"] = field(
        np.float32,
        3,
        unit="brightness",
        low=0.0,
        high=lambda scenario: SLACK * (1.0 + scenario.sensors.ground_noise),
        names=(("left", "middle", "right"),),
        noise=lambda scenario: f"x (1 +- {scenario.sensors.ground_noise:g})",
    )
    """Brightness under the left, middle and right ground sensor: black 0, white 1."""
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
    n: int = field(np.int32)
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


class Action(Record):
    """What a learner does with the layers of one robot. Writer: the environment."""

    weighting: int = field(np.int8)
    """KEEP or REPLACE the hand-written weighting."""
    motion: int = field(np.int8)
    """KEEP, REPLACE, CORRECT or COURSE: what becomes of the hand-written motion."""
    has_reflexes: bool = field(np.bool_)
    """Where a learner steers, the reflexes of the hand-written motion come first."""
    is_walking: bool = field(np.bool_)
    """Where a learner steers, the random walk of the hand-written motion goes on."""
    weight: Float32[Array, " areas"] = field(
        np.float32, 2, unit="weight", low=0.0, high=1.0, names=(AREAS,), label="g"
    )
    """Weight in [0, 1] of what was heard about each area; of no effect where no exchange just
    ended."""
    wheels: Float32[Array, "2"] = field(
        np.float32, 2, unit="of cruise speed", names=(WHEELS,), **SPEED
    )
    """Speed of the left and right wheel, or what is added to it; under COURSE the speed, and the
    angle off the course as a share of WIDEST_OFF_COURSE."""


class EpuckState(Record):
    """The truth about one e-puck, and what it senses, hears and does."""

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
    reward: float = field(np.float32)
    """What the robot earned in the last tick. Writer: the task's `score`."""
    messages: int = field(np.int32)
    """Messages heard. Writer: tick."""
    readings: Readings = field(Readings)
    heard: Heard = field(Heard)
    command: Command = field(Command)
    action: Action = field(Action)

    is_faulty: Int8[Array, " kinds"] = field(np.int8, N_KINDS)
    """A fault of each of KINDS is in effect. Writer: tick."""
    is_silent: bool = field(np.bool_)
    """A fault keeps all that the robot says from being sent. Writer: tick."""
