"""Records of the waypoints world: the world, the robot, and what crosses a layer's border.

Robots that see each other tell each other what they believe, at once and without loss, as in the
paper (BOIDS, Section 3): an estimator may look at what robot j believes, for robot i, where i
sees j or j sees i, and nowhere else.

Numbers that cross a border are float32 in SI units, the same number that an environment shows
in its observation: so a policy in the place of a layer sees what the hand-written layer sees.
"""

import numpy as np

from swarm_forage_env.arrays import Array, Float32, Float64, UInt64
from swarm_forage_env.record import Record, field

ENCODER, LANDMARK, LIDAR, GOAL = range(4)
"""Columns of a robot's random streams."""

SPEED, TURN = 0, 1
"""Columns of what is measured of a robot's motion."""


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

    motion: Float32[Array, "2"] = field(np.float32, 2, unit="m/s, rad/s")
    """Speed [m/s] and turn rate [rad/s] of the last tick, as wheels and gyro tell them."""

    compass: float = field(np.float32, unit="rad")
    """Heading [rad], without error: the authors steer by it, and estimate by the gyro."""

    at_home: bool = field(np.bool_)
    """Home is within reach."""

    home_fix: Float32[Array, "3"] = field(np.float32, 3, unit="m, m, rad")
    """x, y [m] and heading [rad] as home tells them; zeros out of its reach."""

    goal: Float32[Array, "2"] = field(np.float32, 2, unit="m")
    """Where to go next, world frame [m]."""


class Sighting(Record):
    """How one robot sees another after a tick; zeros where it does not. Writer: tick."""

    seen: bool = field(np.bool_)
    """The robot of the row sees the one of the column."""

    range: float = field(np.float32, unit="m")
    """How far it is, as measured."""

    bearing: float = field(np.float32, unit="rad")
    """In which direction of the own body frame."""


class Command(Record):
    """What a controller tells a robot to do in the next tick. Writer: decide."""

    acceleration: Float32[Array, "2"] = field(np.float32, 2, unit="of the highest")
    """Acceleration, ahead and to the left of the body; its direction is the new course. Zeros:
    straight on at the same speed."""

    claim: bool = field(np.bool_)
    """The robot says that it is at its goal, and is given another."""


class Action(Record):
    """What a learner does with the layers of one robot. Writer: the environment."""

    weighting: int = field(np.int8)
    """KEEP or REPLACE the hand-written weighting."""

    motion: int = field(np.int8)
    """KEEP or REPLACE the hand-written motion."""

    weight: Float32[Array, "1"] = field(np.float32, 1)
    """Share in [0, 1] of the correction by all neighbours that is carried out."""

    acceleration: Float32[Array, "2"] = field(np.float32, 2, unit="of the highest")
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

    is_valid: bool = field(np.bool_)
    """There is a correction: the robot sees another, or is seen."""

    neighbours: float = field(np.float32, unit="of all robots")
    """Robots that it sees or that see it."""

    own_covariance_norm: float = field(np.float32)
    """Norm of the own covariance."""

    heard_covariance_norm: float = field(np.float32)
    """Norm of the neighbours' covariances, the mean over them; zero without any."""

    disagreement: float = field(np.float32, unit="m")
    """Distance between where the robot believes it is and where its neighbours, by what they
    believe and where they see it, do on average; zero without any."""

    weight: Float32[Array, "1"] = field(np.float32, 1)
    """Share of the correction that is carried out. Writer: decide."""


class Situation(Record):
    """What the motion layer sees. Vectors are in the body frame that the compass gives.

    Writer: observe.
    """

    goal: Float32[Array, "2"] = field(np.float32, 2, unit="m")
    """To the goal from where the robot believes it is."""

    home: Float32[Array, "2"] = field(np.float32, 2, unit="m")
    """To home."""

    centre: Float32[Array, "2"] = field(np.float32, 2, unit="m")
    """To the middle of the neighbours, by what they believe; zeros without any."""

    separation: Float32[Array, "2"] = field(np.float32, 2)
    """Away from the neighbours; zeros without any."""

    alignment: Float32[Array, "2"] = field(np.float32, 2)
    """Which way the neighbours go; zeros without any."""

    velocity: Float32[Array, "2"] = field(np.float32, 2, unit="m/s")
    """The own velocity, as believed."""

    density: float = field(np.float32, unit="of all robots")
    """Robots seen: rho."""

    covariance_norm: float = field(np.float32, unit="of the highest allowed")
    """Norm of the covariance: s."""

    dead_reckoning_offset: float = field(np.float32, unit="of the highest allowed")
    """Distance between the estimate and dead reckoning: e."""

    has_arrived: bool = field(np.bool_)
    """The robot claims its goal in this tick, and has no other yet."""
