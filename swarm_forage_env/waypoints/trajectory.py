"""What is kept of robots that visit waypoints, in every tick."""

from collections.abc import Mapping

import numpy as np

from swarm_forage_env.arrays import Array
from swarm_forage_env.no_layers import has_estimators
from swarm_forage_env.trajectory import TrajectoryColumn, TrajectoryKind
from swarm_forage_env.waypoints.world import WaypointsWorld


def take(world: WaypointsWorld, minds: Array) -> Mapping[str, Array]:
    """The columns of every robot as it stands."""
    robots = world.robots
    believed, norm = np.full((*robots.shape, 3), np.nan), np.full(robots.shape, np.nan)
    if has_estimators(minds):
        believed, norm = minds["estimator"]["belief"]["pose"], minds["estimator"]["covariance_norm"]
    return {
        "x": robots["pose"][:, :, 0],
        "y": robots["pose"][:, :, 1],
        "heading": robots["pose"][:, :, 2],
        "goal_x": robots["goal"][:, :, 0],
        "goal_y": robots["goal"][:, :, 1],
        "believed_x": believed[:, :, 0],
        "believed_y": believed[:, :, 1],
        "believed_heading": believed[:, :, 2],
        "covariance_norm": norm,
        "seen": np.count_nonzero(world.sightings["seen"], axis=2),
        "right": robots["right"],
        "wrong": robots["wrong"],
    }


WAYPOINT_TRAJECTORY = TrajectoryKind(
    (
        TrajectoryColumn("x", "f4", "true place [m], home is 0"),
        TrajectoryColumn("y", "f4", "true place [m]"),
        TrajectoryColumn("heading", "f4", "true heading [rad], -pi to pi, 0 along x"),
        TrajectoryColumn("goal_x", "f4", "place of the goal [m]"),
        TrajectoryColumn("goal_y", "f4", "place of the goal [m]"),
        TrajectoryColumn("believed_x", "f4", "where it believes it is [m]; empty: no belief"),
        TrajectoryColumn("believed_y", "f4", "where it believes it is [m]; empty: no belief"),
        TrajectoryColumn("believed_heading", "f4", "heading that the robot believes it has [rad]"),
        TrajectoryColumn("covariance_norm", "f4", "spectral norm of the covariance it believes in"),
        TrajectoryColumn("seen", "i4", "robots that it sees in this tick"),
        TrajectoryColumn("right", "i4", "goals claimed so far and reached"),
        TrajectoryColumn("wrong", "i4", "goals claimed so far and not reached"),
    ),
    take,
)
