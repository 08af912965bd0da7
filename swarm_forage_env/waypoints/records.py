"""Records of the waypoints world: the world, the robot, and what crosses a layer's border.

Robots that see each other tell each other what they believe, at once and without loss, as in the
paper (BOIDS, Section 3): an estimator may look at what robot j believes, for robot i, where i
sees j or j sees i, and nowhere else.

What layers see lies in memory as `epuck.records` says.
"""

import math
from functools import partial

import numpy as np

from swarm_forage_env.arrays import Array, Float32, Float64, UInt64
from swarm_forage_env.record import Record, field, flag
from swarm_forage_env.waypoints.scenario import WaypointsScenario

ENCODER, LANDMARK, LIDAR, GOAL = range(4)
"""Columns of a robot's random streams."""

WORDS = 12
"""Numbers in a message of a learner of everything."""

PLACE_SCALE = 2.0
"""Typical distance of a place [m]."""

place = partial(field, np.float32, 2, unit="m", scale=PLACE_SCALE, names=("xy",))
"""A field of the way to a place."""

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
"""Columns of what is measured of a robot's motion."""


def motion_noise(scenario: WaypointsScenario) -> tuple[str, str]:
    """Error of speed and turn rate, in words."""
    sensors = scenario.sensors
    speed, turn = f"{sensors.speed_noise:g} m/s", f"{sensors.turn_noise:g} rad/s"
    return f"sd {speed} and a bias", f"sd {turn} and a bias"


class WorldState(Record):
    """One world: its clock, and the numbers of its scenario as kernels read them."""

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
    """Standard deviation over robots of their constant error."""
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
    """What the robot's own sensors say after a tick. Writer: tick."""

    motion: Float32[Array, "2"] = field(
        np.float32,
        2,
        unit="m/s, rad/s",
        scale=(0.25, 0.5),
        names=(("speed", "turn"),),
        noise=motion_noise,
    )
    """Speed [m/s] and turn rate [rad/s] of the last tick, as wheels and gyro tell them."""
    compass: float = angle()
    """Heading [rad], without error: the authors steer by it, and estimate by the gyro."""
    at_home: float = flag()
    """Home is within reach."""
    home_fix: Float32[Array, "3"] = field(
        np.float32,
        3,
        unit="m, m, rad",
        scale=2.0,
        names=(("x", "y", "heading"),),
        label="fix",
        noise=lambda scenario: f"sd {scenario.sensors.home_noise:g}",
    )
    """x, y [m] and heading [rad] as measured at home; zeros out of its reach."""
    goal: Float32[Array, "2"] = place()
    """Where to go next, world frame [m]."""


class Sighting(Record):
    """How one robot sees another after a tick; zeros where it does not. Writer: tick."""

    seen: float = flag()
    """The robot of the row sees the one of the column."""
    range: float = field(
        np.float32,
        unit="m",
        low=0.0,
        high=lambda scenario: scenario.sensors.reach,
        noise=lambda scenario: f"sd {scenario.sensors.range_noise:g} m",
    )
    """How far it is, as measured."""
    bearing: float = angle(noise=lambda scenario: f"sd {scenario.sensors.bearing_noise:g} rad")
    """In which direction of the own body frame."""


class Command(Record):
    """What a controller commands for the next tick. Writer: decide."""

    acceleration: Float32[Array, "2"] = pull()
    """Acceleration, ahead and to the left of the body; its direction is the new course. Zeros:
    straight on at the same speed."""
    claim: bool = field(np.bool_)
    """The robot claims that it is at its goal, and gets another."""


class Action(Record):
    """What a learner does with the layers of one robot. Writer: the environment."""

    weighting: int = field(np.int8)
    """KEEP or REPLACE the hand-written weighting."""
    motion: int = field(np.int8)
    """KEEP or REPLACE the hand-written motion."""
    weight: Float32[Array, "1"] = field(
        np.float32, 1, unit="weight", low=0.0, high=1.0, names=(("",),), label="g"
    )
    """Share in [0, 1] of the correction by all neighbours that is carried out."""
    acceleration: Float32[Array, "2"] = pull()
    """Acceleration, ahead and to the left of the body."""


class RobotState(Record):
    """The truth about one robot, and what it senses and does."""

    pose: Float64[Array, "3"] = field(np.float64, 3, unit="m, m, rad")
    """x, y [m] and heading [rad], home at the origin. Writers: tick; reset."""
    motion: Float64[Array, "2"] = field(np.float64, 2, unit="m/s, rad/s")
    """Speed and turn rate of the last tick. Writers: tick; reset."""
    goal: Float64[Array, "2"] = field(np.float64, 2, unit="m")
    """Where the robot is to go. Writers: `judge_claim`; reset."""
    deviation: Float64[Array, "2"] = field(np.float64, 2, unit="m/s, rad/s")
    """Standard deviation of the readings of speed and turn rate. Writer: reset."""
    bias: Float64[Array, "2"] = field(np.float64, 2, unit="m/s, rad/s")
    """Their constant error. Writer: reset."""
    streams: UInt64[Array, "4"] = field(np.uint64, 4)
    """Random streams: ENCODER, LANDMARK, LIDAR, GOAL. Writer: tick."""
    right: int = field(np.int32)
    """Goals claimed and reached. Writer: `judge_claim`."""
    wrong: int = field(np.int32)
    """Goals claimed and not reached. Writer: `judge_claim`."""
    reward: float = field(np.float32)
    """Goals rightly claimed in the last tick. Writer: `judge_claim`."""
    readings: Readings = field(Readings)
    command: Command = field(Command)
    action: Action = field(Action)


class Exchange(Record):
    """What the weighting layer sees: the correction by all neighbours that is about to be made."""

    is_valid: float = flag(label="valid")
    """There is a correction: the robot sees another, or is seen."""
    neighbours: float = share_of_robots()
    """Robots that it sees or that see it."""
    own_covariance_norm: float = variance(label="own_doubt")
    """Norm of the own covariance."""
    heard_covariance_norm: float = variance(label="heard_doubt")
    """Norm of the neighbours' covariances, the mean over them; zero without any."""
    disagreement: float = field(np.float32, unit="m", scale=2.0, low=0.0)
    """Distance between where the robot believes it is and where its neighbours, by what they
    believe and where they see it, do on average; zero without any."""
    weight: Float32[Array, "1"] = field(np.float32, 1)
    """Share of the correction that is carried out. Writer: decide."""


class Situation(Record):
    """What the motion layer sees. Vectors are in the body frame that the compass gives.

    Writer: observe.
    """

    goal: Float32[Array, "2"] = place()
    """To the goal from where the robot believes it is."""
    home: Float32[Array, "2"] = place()
    """To home."""
    centre: Float32[Array, "2"] = place()
    """To the middle of the neighbours, by what they believe; zeros without any."""
    separation: Float32[Array, "2"] = direction(label="crowd")
    """Away from the neighbours; zeros without any."""
    alignment: Float32[Array, "2"] = direction(label="flow")
    """Which way the neighbours go; zeros without any."""
    velocity: Float32[Array, "2"] = field(np.float32, 2, unit="m/s", scale=0.25, names=("xy",))
    """The own velocity, as believed."""
    density: float = share_of_robots()
    """Robots seen: rho."""
    covariance_norm: float = share(label="doubt")
    """Norm of the covariance, as a share of the highest allowed: s."""
    dead_reckoning_offset: float = share(label="drift")
    """Distance between the estimate and dead reckoning, as a share of the highest allowed: e."""
    has_arrived: float = flag(label="arrived")
    """The robot claims its goal in this tick, and has no other yet."""


class PolicyMessages(Record):
    """Messages that a learner of everything sends and receives, and its claims."""

    claim: float = word(unit="at the goal if > 0")
    """Whether the robot is at its goal: another one, please. Writer: the environment."""
    words: Float32[Array, " words"] = word(WORDS, unit="as sent")
    """The message, whose meaning is the policy's. Writer: the environment."""
    heard: Float32[Array, "robots words"] = word("robots", WORDS, unit="as sent", label="words")
    """What each robot that is seen says; zeros of others. Writer: observe."""
