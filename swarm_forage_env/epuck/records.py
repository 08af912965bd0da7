"""Records of e-pucks: the robot, its sensors and radio, and its world.

A task adds its own fields in subclasses of `EpuckState` and `EpuckWorldState`.

The inputs of layers are float32 in SI units, with flags as 0 or 1, and have the memory layout of
observations: a policy that replaces a layer observes the inputs of the hand-written layer. Their
typical sizes are the same in all scenarios, so that a policy can be used in other scenarios.
"""

import math
from typing import Any

import numpy as np

from swarm_forage_env.arrays import Array, Float32, Float64, Int8, Int32, UInt64
from swarm_forage_env.epuck.fault_record import N_KINDS, FaultNumbers
from swarm_forage_env.epuck.scenario import EpuckScenario
from swarm_forage_env.record import Record, field, flag

SLACK = 1.01
"""Factor that allows for rounding to float32."""


def max_step(scenario: EpuckScenario) -> float:
    """Return the largest path of a wheel in a tick that its encoder, worn or not, reads [m]."""
    robot, noise = scenario.robot, scenario.sensors.wheel_noise
    speed, worn = robot.max_speed, scenario.faults.worn
    if worn.is_any:
        speed, noise = speed * (1.0 + worn.bias), noise * max(worn.noise_factor, 1.0)
    return SLACK * (speed + noise * robot.cruise_speed) * scenario.tick


def max_turn(scenario: EpuckScenario) -> float:
    """Return the largest turn in a tick that the encoders read [rad]."""
    return 2.0 * max_step(scenario) / scenario.robot.axle


def odometry_noise(scenario: EpuckScenario) -> tuple[str, str]:
    """Return the errors of distance and turn in words."""
    robot = scenario.robot
    error = scenario.sensors.wheel_noise * robot.cruise_speed * scenario.tick
    return f"+- {error:.3g} m", f"+- {2.0 * error / robot.axle:.3g} rad"


def range_noise(scenario: EpuckScenario) -> str:
    """Return the error of the range of one frame in words."""
    if scenario.radio.is_board:
        return "lognormal, as the real board, each frame"
    return f"+- {scenario.radio.range_noise:g} m, each frame"


def bearing_noise(scenario: EpuckScenario) -> str:
    """Return the error of a bearing of one frame in words."""
    return f"+- {scenario.radio.bearing_noise:.3g} rad, each frame"


AREAS = ("nest", "prey")
WHEELS = ("left", "right")

SPEED: dict[str, Any] = {"low": -1.0, "high": 1.0}

ENCODER, PROXIMITY, GROUND, LOSS, SLOT, RADIO = range(6)
"""Columns of a robot's random streams."""


class EpuckWorldState(Record):
    """World of e-pucks: its clock, and the scenario parameters in the form that kernels read."""

    ticks: int = field(np.int64)
    """Ticks since reset. Writer: tick."""
    has_moved: bool = field(np.bool_)
    """Whether the engine has already moved the robots in this tick. Writers: engine, tick."""
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
    """Distance within which robots are listed as neighbours, centre to centre."""
    n_obstacles: int = field(np.int64)
    """Number of capsules in this world's row of `obstacles`; the rest is padding."""
    is_shadowed: bool = field(np.bool_)
    """Whether an obstacle between two robots blocks their messages."""
    has_faults: bool = field(np.bool_)
    """Whether any robot may be faulty."""
    faults: FaultNumbers = field(FaultNumbers)

    is_crowded: bool = field(np.bool_)
    """Whether contacts must be resolved, as robots overlap or there are obstacles; false between
    ticks. Writer: tick."""


class Readings(Record):
    """Readings of the robot's sensors after a tick. Writer: tick."""

    proximity: Float32[Array, "8"] = field(
        np.float32,
        8,
        unit="reading",
        low=0.0,
        high=1.0,
        noise=lambda scenario: f"x (1 +- {scenario.sensors.proximity_noise:g})",
    )
    """Infrared readings at PROXIMITY_ANGLES of the body frame: 1 at contact, 0 beyond 5 cm."""
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
    """Distance [m] and turn [rad] since the last tick, as measured by the wheel encoders."""


class Heard(Record):
    """Messages that a robot receives in a tick; slots from `n` on are zero. Writer: tick."""

    is_valid: Float32[Array, " slots"] = flag("slots", label="valid")
    """Whether the slot holds a message."""
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
    """Number of frames averaged in the measurement: several while the receiver stands still."""
    n: int = field(np.int32)
    """Number of messages received."""
    sender: Int32[Array, " slots"] = field(np.int32, "slots")
    """Index of the sender in the same world: 0 .. N - 1; stale from `n` on."""


class Command(Record):
    """Command of a controller to a robot for the next tick. Writer: decide."""

    wheels: Float32[Array, "2"] = field(
        np.float32, 2, unit="of cruise speed", names=(WHEELS,), **SPEED
    )
    """Speed of the left and right wheel, limited to robot.max_speed by the motors."""
    is_speaking: bool = field(np.bool_)
    """Whether the robot broadcasts its message."""


class Action(Record):
    """Action of a learner on the layers of one robot. Writer: the environment."""

    weighting: int = field(np.int8)
    """Effect on the hand-written weighting: KEEP or REPLACE."""
    motion: int = field(np.int8)
    """Effect on the hand-written motion: KEEP, REPLACE, CORRECT or COURSE."""
    has_reflexes: bool = field(np.bool_)
    """Whether the reflexes of the hand-written motion override a learner that steers."""
    is_walking: bool = field(np.bool_)
    """Whether the random walk of the hand-written motion continues while a learner steers."""
    weight: Float32[Array, " areas"] = field(
        np.float32, 2, unit="weight", low=0.0, high=1.0, names=(AREAS,), label="g"
    )
    """Weight in [0, 1] of the received estimate of each area; without effect unless an exchange
    has just ended."""
    wheels: Float32[Array, "2"] = field(
        np.float32, 2, unit="of cruise speed", names=(WHEELS,), **SPEED
    )
    """Speed of the left and right wheel, or a correction of it; with COURSE the speed, and the
    angle off the course as a share of WIDEST_OFF_COURSE."""


class EpuckState(Record):
    """State of one e-puck: ground truth, readings, received messages, command and action."""

    pose: Float64[Array, "3"] = field(np.float64, 3, unit="m, m, rad")
    """x, y [m] and heading [rad] in the world frame. Writers: engine, tick; reset."""
    heading: Float64[Array, "2"] = field(np.float64, 2)
    """Cosine and sine of the heading. Writer: tick."""
    wheels: Float64[Array, "2"] = field(np.float64, 2, unit="m/s")
    """Speed of the left and right wheel in the last tick. Writers: engine, tick."""
    streams: UInt64[Array, "6"] = field(np.uint64, 6)
    """Random streams: ENCODER, PROXIMITY, GROUND, LOSS, SLOT, RADIO. Writer: tick."""
    rays: Float64[Array, "8"] = field(np.float64, 8, unit="m", start=np.inf)
    """Length of each infrared ray from the rim; infinite beyond its range. Writer: tick."""
    reward: float = field(np.float32)
    """Reward of the robot in the last tick. Writer: the task's `score`."""
    messages: int = field(np.int32)
    """Number of messages received so far. Writer: tick."""
    readings: Readings = field(Readings)
    heard: Heard = field(Heard)
    command: Command = field(Command)
    action: Action = field(Action)

    is_faulty: Int8[Array, " kinds"] = field(np.int8, N_KINDS)
    """Whether a fault of each of KINDS is in effect. Writer: tick."""
    is_silent: bool = field(np.bool_)
    """Whether a fault prevents the robot from sending messages. Writer: tick."""
