"""Records of the waypoints world: the world, the robot, and the inputs and outputs of layers.

Robots that see each other exchange their beliefs at once and without loss: the paper limits
communication by its radius only (BOIDS, Section III.2). An estimator may read the belief of robot j
for robot i only if i sees j or j sees i.

The memory layout of the inputs of layers is that of `epuck.records`.
"""

import math
from functools import partial

import numpy as np

from swarm_forage_env.arrays import Array, Float32, Float64, UInt64
from swarm_forage_env.record import Record, field, flag
from swarm_forage_env.waypoints.scenario import WaypointsScenario

ENCODER, LANDMARK, LIDAR, GOAL = range(4)
"""Columns of the random streams of a robot."""

WORDS = 12
"""Length of a message under `learn=everything`."""

PLACE_SCALE = 2.0
"""Typical distance to a place [m]."""

place = partial(field, np.float32, 2, unit="m", scale=PLACE_SCALE, names=("xy",))
"""Field for the displacement to a place."""

direction = partial(field, np.float32, 2, scale=1.0, names=("xy",))
pull = partial(
    field,
    np.float32,
    2,
    unit="of the highest acceleration",
    names=("xy",),
    label="pull",
    low=-1.0,
    high=1.0,
)
variance = partial(field, np.float32, unit="m^2", scale=0.1, low=0.0)
share = partial(field, np.float32, unit="share", scale=1.0, low=0.0)
share_of_robots = partial(field, np.float32, unit="of all robots", low=0.0, high=1.0)
angle = partial(field, np.float32, unit="rad", low=-math.pi, high=math.pi)
word = partial(field, np.float32, low=-1.0, high=1.0)

SPEED, TURN = 0, 1
"""Columns of the motion of a robot."""


def motion_noise(scenario: WaypointsScenario) -> tuple[str, str]:
    """Describe the errors of speed and turn rate."""
    sensors = scenario.sensors
    speed, turn = f"{sensors.speed_noise:g} m/s", f"{sensors.turn_noise:g} rad/s"
    return f"sd {speed} and a bias", f"sd {turn} and a bias"


class WorldState(Record):
    """One world: its clock, and the parameters of its scenario in the form that kernels read."""

    ticks: int = field(np.int64)
    """Ticks since reset. Writer: tick."""
    dt: float = field(np.float64, unit="s")
    max_speed: float = field(np.float64, unit="m/s")
    min_speed: float = field(np.float64, unit="m/s")
    max_turn_rate: float = field(np.float64, unit="rad/s")
    max_acceleration: float = field(np.float64, unit="m/s^2")

    noise: Float64[Array, "2"] = field(np.float64, 2, unit="m/s, rad/s")
    """Standard deviation of the readings of speed and turn rate."""
    bias: Float64[Array, "2"] = field(np.float64, 2, unit="m/s, rad/s")
    """Standard deviation, over robots, of the constant error of these readings."""
    spread: float = field(np.float64)
    reach: float = field(np.float64, unit="m")
    range_noise: float = field(np.float64, unit="m")
    bearing_noise: float = field(np.float64, unit="rad")
    home_noise: float = field(np.float64, unit="m, m, rad")

    tolerance: float = field(np.float64, unit="m")
    half_side: float = field(np.float64, unit="m")
    start_half_side: float = field(np.float64, unit="m")
    first_goal: float = field(np.float64, unit="m")


class Readings(Record):
    """Readings of the sensors of one robot after a tick. Writer: tick."""

    motion: Float32[Array, "2"] = field(
        np.float32,
        2,
        unit="m/s, rad/s",
        scale=(0.25, 0.5),
        names=(("speed", "turn"),),
        noise=motion_noise,
    )
    """Speed [m/s] and turn rate [rad/s] of the last tick, measured by wheels and gyro."""
    compass: float = angle()
    """Heading without error [rad]: the authors steer by the compass and estimate by the gyro."""
    at_home: float = flag()
    """Whether home is within reach."""
    home_fix: Float32[Array, "3"] = field(
        np.float32,
        3,
        unit="m, m, rad",
        scale=2.0,
        names=(("x", "y", "heading"),),
        label="fix",
        noise=lambda scenario: f"sd {scenario.sensors.home_noise:g}",
    )
    """x, y [m] and heading [rad] measured near home; zeros out of reach."""
    goal: Float32[Array, "2"] = place()
    """Position of the goal, world frame [m]."""


class Sighting(Record):
    """Sighting of one robot by another after a tick; zeros if it is not seen. Writer: tick."""

    seen: float = flag()
    """Whether the robot of the row sees the robot of the column."""
    range: float = field(
        np.float32,
        unit="m",
        low=0.0,
        high=lambda scenario: scenario.sensors.reach,
        noise=lambda scenario: f"sd {scenario.sensors.range_noise:g} m",
    )
    """Measured distance."""
    bearing: float = angle(noise=lambda scenario: f"sd {scenario.sensors.bearing_noise:g} rad")
    """Measured direction in the body frame of the observing robot."""


class Command(Record):
    """Command of a controller for the next tick. Writer: decide."""

    acceleration: Float32[Array, "2"] = pull()
    """Acceleration ahead and to the left of the body; its direction is the new course. Zeros keep
    speed and course."""
    claim: bool = field(np.bool_)
    """Whether the robot claims to be at its goal; it then gets a new goal."""


class Action(Record):
    """Action of a policy that replaces layers of one robot. Writer: the environment."""

    weighting: int = field(np.int8)
    """KEEP or REPLACE: whether the policy replaces the weighting."""
    motion: int = field(np.int8)
    """KEEP or REPLACE: whether the policy replaces the motion."""
    weight: Float32[Array, "1"] = field(
        np.float32, 1, unit="weight", low=0.0, high=1.0, names=(("",),), label="g"
    )
    """Weight in [0, 1] of the correction by all neighbours."""
    acceleration: Float32[Array, "2"] = pull()
    """Acceleration ahead and to the left of the body."""


class RobotState(Record):
    """True state of one robot, its readings, command and action."""

    pose: Float64[Array, "3"] = field(np.float64, 3, unit="m, m, rad")
    """x, y [m] and heading [rad], home at the origin. Writers: tick; reset."""
    motion: Float64[Array, "2"] = field(np.float64, 2, unit="m/s, rad/s")
    """Speed and turn rate of the last tick. Writers: tick; reset."""
    goal: Float64[Array, "2"] = field(np.float64, 2, unit="m")
    """Position of the goal. Writers: `judge_claim`; reset."""
    deviation: Float64[Array, "2"] = field(np.float64, 2, unit="m/s, rad/s")
    """Standard deviation of the readings of speed and turn rate. Writer: reset."""
    bias: Float64[Array, "2"] = field(np.float64, 2, unit="m/s, rad/s")
    """Constant error of these readings. Writer: reset."""
    streams: UInt64[Array, "4"] = field(np.uint64, 4)
    """Random streams: ENCODER, LANDMARK, LIDAR, GOAL. Writer: tick."""
    right: int = field(np.int32)
    """Number of goals claimed and reached. Writer: `judge_claim`."""
    wrong: int = field(np.int32)
    """Number of goals claimed but not reached. Writer: `judge_claim`."""
    reward: float = field(np.float32)
    """1 if the robot claimed and reached its goal in the last tick. Writer: `judge_claim`."""
    readings: Readings = field(Readings)
    command: Command = field(Command)
    action: Action = field(Action)


class Exchange(Record):
    """Input of the weighting layer: the pending correction by all neighbours."""

    is_valid: float = flag(label="valid")
    """Whether there is a correction: the robot sees another one or is seen."""
    neighbours: float = share_of_robots()
    """Share of robots that it sees or that see it."""
    own_covariance_norm: float = variance(label="own_doubt")
    """Norm of the covariance of the robot."""
    heard_covariance_norm: float = variance(label="heard_doubt")
    """Mean norm of the covariances of the neighbours; zero without neighbours."""
    disagreement: float = field(np.float32, unit="m", scale=2.0, low=0.0)
    """Distance between the estimated position and the mean of the positions that the neighbours
    infer from their beliefs and sightings; zero without neighbours."""
    weight: Float32[Array, "1"] = field(np.float32, 1)
    """Weight of the correction. Writer: decide."""


class Situation(Record):
    """Input of the motion layer; vectors are in the body frame by the compass. Writer: observe."""

    goal: Float32[Array, "2"] = place()
    """Displacement from the estimated position to the goal."""
    home: Float32[Array, "2"] = place()
    """Displacement from the estimated position to home."""
    centre: Float32[Array, "2"] = place()
    """Displacement to the mean estimated position of the neighbours; zeros without neighbours."""
    separation: Float32[Array, "2"] = direction(label="crowd")
    """Direction away from the neighbours; zeros without neighbours."""
    alignment: Float32[Array, "2"] = direction(label="flow")
    """Direction in which the neighbours move; zeros without neighbours."""
    velocity: Float32[Array, "2"] = field(np.float32, 2, unit="m/s", scale=0.25, names=("xy",))
    """Estimated velocity of the robot."""
    density: float = share_of_robots()
    """Share of robots seen: rho."""
    covariance_norm: float = share(label="doubt")
    """Norm of the covariance, as a share of the largest allowed norm: s."""
    dead_reckoning_offset: float = share(label="drift")
    """Distance between the estimate and dead reckoning, as a share of the largest allowed: e."""
    has_arrived: float = flag(label="arrived")
    """Whether the robot claims its goal in this tick and has no new goal yet."""


class PolicyMessages(Record):
    """Messages sent and received, and claims, under `learn=everything`."""

    claim: float = word(unit="at the goal if > 0")
    """Positive if the robot claims to be at its goal, to get a new one. Writer: the environment."""
    words: Float32[Array, " words"] = word(WORDS, unit="as sent")
    """The message; the policy defines its meaning. Writer: the environment."""
    heard: Float32[Array, "robots words"] = word("robots", WORDS, unit="as sent", label="words")
    """Messages of the robots that are seen; zeros for other robots. Writer: observe."""
