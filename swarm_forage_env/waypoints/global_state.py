"""Global state of a waypoints world for critics and logs, and its trajectories."""

import math
from collections.abc import Mapping

import numpy as np

from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.compiler import kernel
from swarm_forage_env.global_state import GlobalState, TrajectoryColumn, TrajectoryKind
from swarm_forage_env.raw_control import has_estimators
from swarm_forage_env.spaces import Feature
from swarm_forage_env.waypoints.control import Mind
from swarm_forage_env.waypoints.records import PLACE_SCALE, RobotState, WorldState
from swarm_forage_env.waypoints.world import WaypointsWorld


@kernel
def log_claims(
    robot: RobotState, mind: Mind, world: WorldState, row: Float64[Array, " infos"]
) -> None:
    """Write the numbers of right and wrong claims of a robot so far."""
    row[0], row[1] = robot.right, robot.wrong


@kernel
def log_beliefs(
    robot: RobotState, mind: Mind, world: WorldState, row: Float64[Array, " infos"]
) -> None:
    """Write the numbers of right and wrong claims of a robot, and its position error [m]."""
    log_claims(robot, mind, world, row)
    believed = mind.belief.pose
    row[2] = math.hypot(believed[0] - robot.pose[0], believed[1] - robot.pose[1])


class WaypointsState(GlobalState):
    """The true state of each world of a block, as a flat vector: all robots, then the time.

    The features of a robot are its pose, its goal and its estimated position; the estimate is zero
    if no hand-written estimator runs. The logs hold right and wrong claims so far, and the
    position error.
    """

    infos = ("goals", "false_goals", "position_error_m")
    logs = log_claims, log_beliefs
    counts = frozenset({"goals", "false_goals"})

    def robot_features(self) -> list[Feature]:
        """Return the features of one robot: pose, goal and estimated position."""
        x, y, *others = (
            Feature(f"{what}.{axis}", "m", -math.inf, math.inf, scale=PLACE_SCALE)
            for what in ("pose", "goal", "believed")
            for axis in "xy"
        )
        heading = (Feature(f"heading.{name}", "", -1.0, 1.0) for name in ("cos", "sin"))
        return [x, y, *heading, *others]

    def of_robots(self) -> list[Array]:
        """Return the arrays with these features of all robots."""
        robots = self._world.robots
        theta, believed = robots["pose"][:, :, 2], np.zeros_like(robots["goal"])
        if self._has_beliefs:
            believed = self._controller.minds["estimator"]["belief"]["pose"][:, :, :2]
        heading = np.stack([np.cos(theta), np.sin(theta)], axis=2)
        return [robots["pose"][:, :, :2], heading, robots["goal"], believed]


def take(world: WaypointsWorld, minds: Array) -> Mapping[str, Array]:
    """Return the current trajectory columns of every robot."""
    robots = world.robots
    believed, norm = np.full((*robots.shape, 3), np.nan), np.full(robots.shape, np.nan)
    if has_estimators(minds):
        believed, norm = minds["estimator"]["belief"]["pose"], minds["estimator"]["covariance_norm"]
    vectors = np.concatenate([robots["pose"], robots["goal"], believed], axis=2)
    seen = np.count_nonzero(world.sightings["seen"], axis=2)
    columns = *np.moveaxis(vectors, 2, 0), norm, seen, robots["right"], robots["wrong"]
    return dict(zip(WAYPOINT_TRAJECTORY.names, columns, strict=True))


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
