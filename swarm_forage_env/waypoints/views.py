"""What the layers of robots that visit waypoints are shown, as arrays with a row for each robot."""

from dataclasses import dataclass

import numpy as np

from swarm_forage_env.arrays import Array, Bool, Float32, Float64, checked
from swarm_forage_env.no_layers import estimators_of
from swarm_forage_env.record import rows
from swarm_forage_env.waypoints.world import WaypointsWorld


@checked
@dataclass(frozen=True, slots=True)
class WeightingInput:
    """What the weighting layer sees: the correction by all neighbours that is about to be made."""

    valid: Bool[Array, " rows"]
    """There is a correction."""

    neighbours: Float32[Array, " rows"]
    """Robots that see it or that it sees, as a share of all robots."""

    own_doubt: Float32[Array, " rows"]
    """Norm of the own covariance."""

    heard_doubt: Float32[Array, " rows"]
    """Norm of the neighbours' covariances, the mean over them; zero without any."""

    disagreement: Float32[Array, " rows"]
    """Distance between where the robot believes it is and where its neighbours, by what they
    believe and where they see it, do on average [m]; zero without any."""


@checked
@dataclass(frozen=True, slots=True)
class MotionInput:
    """What the motion layer sees. Vectors are in the body frame that the compass gives."""

    goal: Float32[Array, "rows 2"]
    """To the goal from where the robot believes it is [m]."""

    home: Float32[Array, "rows 2"]
    """To home [m]."""

    centre: Float32[Array, "rows 2"]
    """To the middle of the neighbours, by what they believe [m]; zeros without any."""

    crowd: Float32[Array, "rows 2"]
    """Separation: away from the neighbours; zeros without any."""

    flow: Float32[Array, "rows 2"]
    """Alignment: which way the neighbours go; zeros without any."""

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
    """The last commanded acceleration, as a share of the highest."""


def exchange_of(world: WaypointsWorld, minds: Array) -> WeightingInput:
    """The corrections that all robots are about to make."""
    e = rows(estimators_of(minds)["exchange"])
    return WeightingInput(
        valid=e.is_valid.copy(),
        neighbours=e.neighbours.copy(),
        own_doubt=e.own_covariance_norm.copy(),
        heard_doubt=e.heard_covariance_norm.copy(),
        disagreement=e.disagreement.copy(),
    )


def situation_of(world: WaypointsWorld, minds: Array) -> MotionInput:
    """The situations of all robots."""
    s = rows(estimators_of(minds)["situation"])
    return MotionInput(
        goal=s.goal.copy(),
        home=s.home.copy(),
        centre=s.centre.copy(),
        crowd=s.separation.copy(),
        flow=s.alignment.copy(),
        velocity=s.velocity.copy(),
        density=s.density.copy(),
        doubt=s.covariance_norm.copy(),
        drift=s.dead_reckoning_offset.copy(),
        arrived=s.has_arrived.copy(),
        pull=rows(world.robots).command.acceleration.copy(),
    )


def estimated_pose_of(minds: Array) -> Float64[Array, "rows 3"]:
    """Where the robots believe to be: x, y [m] and heading [rad]."""
    pose: Float64[Array, "rows 3"] = np.array(rows(estimators_of(minds)["belief"]).pose)
    return pose


def covariance_norm_of(minds: Array) -> Float64[Array, " rows"]:
    """Spectral norm of the covariance of each robot's estimate."""
    norm: Float64[Array, " rows"] = np.array(rows(estimators_of(minds)).covariance_norm)
    return norm
