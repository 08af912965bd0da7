"""Drawing of a waypoints world: its stage, and a scene for each tick."""

import numpy as np

from swarm_forage_env import scene
from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.raw_control import has_estimators
from swarm_forage_env.record import rows
from swarm_forage_env.waypoints.scenario import WaypointsScenario
from swarm_forage_env.waypoints.world import WaypointsWorld

MARGIN = 1.0
"""Floor drawn around the square of goals [m]; there are no walls."""

BODY_RADIUS = 0.17
"""Radius of an iRobot Create [m]; no scenario sets it, since there are no contacts."""

SEEING = {scene.EXPLORING: "sees nobody", scene.TALKING: "sees others"}
"""Names of the states of robots; robots that see each other exchange their beliefs."""


def stage_of(scenario: WaypointsScenario, controller: str) -> scene.Stage:
    """Return the stage of a scenario, labelled with the name of its controller."""
    task = scenario.task
    side = task.side + 2.0 * MARGIN
    return scene.Stage(
        scenario=scenario.name,
        controller=controller,
        length=side,
        width=side,
        areas=np.zeros((0, 2)),
        kinds=(),
        names=(),
        area_radius=0.0,
        start_radius=0.0,
        robot_radius=BODY_RADIUS,
        n_robots=task.n_robots,
        tick=scenario.tick,
        duration=scenario.n_ticks * scenario.tick,
        states=tuple(SEEING.get(code, "") for code in range(len(scene.STATES))),
        goals=scene.GoalField(task.side, task.tolerance, scenario.sensors.reach),
        headings=("Goals reached", "Within ellipse"),
    )


def scene_of(world: WaypointsWorld, minds: Array, w: int = 0) -> scene.Scene:
    """Return the current scene of one world; without estimates if there are no estimators."""
    robots, n = world.robots[w].view(np.recarray), world.n_robots
    pose, seen = robots.pose.copy(), world.sightings["seen"][w]
    believed, ellipse = pose[:, :2].copy(), np.zeros((n, 3))
    if has_estimators(minds):
        belief = rows(minds["estimator"]["belief"][w])
        believed, ellipse = belief.pose[:, :2].copy(), ellipses(belief.P[:, :2, :2])
    receiver, sender = np.nonzero(seen)
    goal, right, wrong = robots.goal.copy(), robots.right.copy(), robots.wrong.copy()
    fields = {
        "activity": np.where(seen.any(axis=1), scene.TALKING, scene.EXPLORING).astype(np.int8),
        "time": float(world.worlds["ticks"][w]) * world.scenarios[w].tick,
        "pose": pose,
        "messages": np.stack([sender, receiver], axis=1).astype(np.int32),
        "localised": scene.Localised(goal, believed, ellipse, right, wrong),
    }
    return scene.Scene(**scene.without_beliefs(n) | fields)


def ellipses(covariance: Float64[Array, "robots 2 2"]) -> Float64[Array, "robots 3"]:
    """Return the standard deviations along both axes [m], longer first, and its angle [rad].

    The covariances are those of positions [m^2].
    """
    xx, xy, yy = covariance[:, 0, 0], covariance[:, 0, 1], covariance[:, 1, 1]
    mean, half = 0.5 * (xx + yy), np.hypot(0.5 * (xx - yy), xy)
    axes = np.sqrt(np.maximum(np.stack([mean + half, mean - half]), 0.0))
    return np.stack([*axes, 0.5 * np.arctan2(2.0 * xy, xx - yy)], axis=1)
