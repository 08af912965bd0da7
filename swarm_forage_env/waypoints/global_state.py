"""What is told of a waypoints world: global state for critics, logs, and trajectories."""

import math
from collections.abc import Mapping

import numpy as np

from swarm_forage_env.arrays import Array, Float32, Float64
from swarm_forage_env.interface import RunningController
from swarm_forage_env.no_layers import has_estimators
from swarm_forage_env.record import rows
from swarm_forage_env.spaces import Feature, Layout
from swarm_forage_env.trajectory import TrajectoryColumn, TrajectoryKind
from swarm_forage_env.waypoints.records import PLACE
from swarm_forage_env.waypoints.scenario import WaypointsScenario
from swarm_forage_env.waypoints.world import WaypointsWorld

INFOS = ("goals", "false_goals", "position_error_m")
"""What is logged of each robot: claims right and wrong so far, and how far its belief is off."""

COUNTS = frozenset({"goals", "false_goals"})
"""Those of which several robots have the sum; of everything else they have the mean."""


class WaypointsState:
    """What is true in a block of worlds, flat: each robot, then the time.

    Of each robot: pose, goal, and where it believes to be; zeros for the belief where no
    hand-written estimator runs.
    """

    infos = INFOS
    counts = COUNTS

    def __init__(
        self,
        world: WaypointsWorld,
        controller: RunningController,
        agents: list[str],
        scenario: WaypointsScenario,
    ) -> None:
        """The truth about these worlds, whose robots have these names."""
        self._world = world
        self._controller = controller
        self._has_beliefs = has_estimators(controller.minds)
        names = ("pose.x", "pose.y", "heading.cos", "heading.sin", "goal.x", "goal.y")
        believed = ("believed.x", "believed.y")
        features = [
            Feature(f"{agent}.{name}", "", -1.0, 1.0)
            if name.startswith("heading")
            else Feature(f"{agent}.{name}", "m", -math.inf, math.inf, scale=PLACE["scale"])
            for agent in agents
            for name in (*names, *believed)
        ]
        self.layout = Layout([*features, Feature("share_gone", "of the episode", 0.0, 1.0)])
        self.space = self.layout.box()

    def state(self, share_gone: Float64[Array, " worlds"]) -> Float32[Array, "worlds numbers"]:
        """One row for each world, as the layout says."""
        state, worlds, believed = self._world.state, self._world.n_worlds, self._believed()
        x, y, theta = state.pose.T
        if believed is None:
            believed = np.zeros_like(state.goal)
        parts = [np.stack([x, y, np.cos(theta), np.sin(theta)], axis=1), state.goal, believed]
        robots = np.concatenate(parts, axis=1).reshape(worlds, -1)
        gone = np.minimum(share_gone, 1.0)[:, None]
        return np.concatenate([robots, gone], axis=1, dtype=np.float32)

    def log(self) -> Float64[Array, "rows infos"]:
        """The numbers that are logged, a row for each robot, in the order of INFOS."""
        state, believed = rows(self._world.robots), self._believed()
        off = np.zeros(self._world.rows)
        if believed is not None:
            off = np.hypot(*(believed - state.pose[:, :2]).T)
        return np.stack([state.right, state.wrong, off], axis=1)

    def _believed(self) -> Float64[Array, "rows 2"] | None:
        """Where the robots believe to be, if a hand-written estimator runs."""
        if not self._has_beliefs:
            return None
        place: Float64[Array, "rows 2"]
        place = rows(self._controller.minds["estimator"]["belief"]).pose[:, :2]
        return place


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
