"""All that a controller of the waypoints world may know and say.

Robots that see each other tell each other what they believe, at once and without loss, as in the
paper (BOIDS 3): an estimator may look at what robot j believes, for robot i, where `seen[i, j]`
or `seen[j, i]` holds, and nowhere else.

Columns `robots` number the robots of the same world.
"""

from dataclasses import dataclass

from swarm_forage_env.arrays import Array, Bool, Float32, checked


@checked
@dataclass(frozen=True, slots=True)
class WaypointReadings:
    """What the robot's own sensors say after a tick."""

    motion: Float32[Array, "rows 2"]
    """Speed [m/s] and turn rate [rad/s] of the last tick, as wheels and gyro tell them."""

    compass: Float32[Array, " rows"]
    """Heading [rad], without error: the authors steer by it, and estimate by the gyro."""

    at_home: Bool[Array, " rows"]
    """Home is within reach."""

    fix: Float32[Array, "rows 3"]
    """x, y [m] and heading [rad] as home tells them; zeros out of its reach."""

    goal: Float32[Array, "rows 2"]
    """Where to go next, world frame [m]."""


@checked
@dataclass(frozen=True, slots=True)
class Sightings:
    """Who sees whom after a tick, and where: a row of robots of its world for each robot."""

    seen: Bool[Array, "rows robots"]
    """The robot of the row sees the one of the column."""

    range: Float32[Array, "rows robots"]
    """How far it is, as measured [m]; zero where not seen."""

    bearing: Float32[Array, "rows robots"]
    """In which direction of the own body frame [rad]; zero where not seen."""


@checked
@dataclass(frozen=True, slots=True)
class WaypointFeedback:
    """What comes back from a tick of the waypoints world."""

    readings: WaypointReadings
    heard: Sightings
    reward: Float32[Array, " rows"]
    """Goals rightly claimed in this tick."""
    done: Bool[Array, " worlds"]
    """The episode of this world is over."""


@checked
@dataclass(frozen=True, slots=True)
class WaypointCommand:
    """What a controller tells the robots to do in the next tick."""

    pull: Float32[Array, "rows 2"]
    """Acceleration, ahead and to the left of the body, as a share of the highest; its direction
    is the new course. Zeros: straight on at the same speed."""

    claim: Bool[Array, " rows"]
    """I am at my goal: give me another."""


@checked
@dataclass(frozen=True, slots=True)
class Correction:
    """What the weighting layer sees: the correction by all neighbours that is about to be made."""

    valid: Bool[Array, " rows"]
    """There is a correction."""

    neighbours: Float32[Array, " rows"]
    """Robots seen, as a share of all robots."""

    own_doubt: Float32[Array, " rows"]
    """Norm of the own covariance."""

    heard_doubt: Float32[Array, " rows"]
    """Norm of the neighbours' covariances, the mean over them; zero without any."""

    disagreement: Float32[Array, " rows"]
    """Distance between where the robot believes it is and where its neighbours, by what they
    believe and where they see it, do on average [m]; zero without any."""


@checked
@dataclass(frozen=True, slots=True)
class WaypointSituation:
    """What the motion layer sees. Vectors are in the body frame that the compass gives."""

    goal: Float32[Array, "rows 2"]
    """To the goal from where the robot believes it is [m]."""

    home: Float32[Array, "rows 2"]
    """To home [m]."""

    centre: Float32[Array, "rows 2"]
    """To the middle of the neighbours, by what they believe [m]; zeros without any."""

    crowd: Float32[Array, "rows 2"]
    """Away from the neighbours; zeros without any."""

    flow: Float32[Array, "rows 2"]
    """Which way the neighbours go; zeros without any."""

    velocity: Float32[Array, "rows 2"]
    """The own velocity, as believed [m/s]."""

    density: Float32[Array, " rows"]
    """Robots seen, as a share of all robots: rho."""

    doubt: Float32[Array, " rows"]
    """Norm of the covariance, as a share of the highest allowed: s."""

    drift: Float32[Array, " rows"]
    """Distance between the estimate and dead reckoning, as a share of the highest allowed: e."""

    arrived: Bool[Array, " rows"]
    """The robot claims its goal in this tick, and has no other yet."""

    pull: Float32[Array, "rows 2"]
    """The last command."""
