"""The global state of a foraging world, for centralised critics and for the logs."""

from dataclasses import replace
from typing import Any

import numpy as np
from gymnasium.spaces import Box

from swarm_forage_env.arrays import Array, Float32, Float64
from swarm_forage_env.compiler import entry_point
from swarm_forage_env.equations.geometry import to_outer
from swarm_forage_env.foraging.bounds import Bounds
from swarm_forage_env.foraging.metrics import believed_places
from swarm_forage_env.foraging.observations import AREAS, FLAG, PATH_SCALE, PLACE_SCALE
from swarm_forage_env.foraging.records import Situation
from swarm_forage_env.foraging.world import ForagingWorld
from swarm_forage_env.record import rows
from swarm_forage_env.spaces import GOALS, Feature, Layout, goal_slots

INFOS = (
    "round_trips",
    "lost_events",
    "on_path",
    "messages",
    "known_areas",
    "localisation_error_m",
)
"""What is logged of each robot: counts of the episode so far, and how it stands. The error is
the mean over the areas that it knows, 0 if none."""

COUNTS = frozenset({"round_trips", "lost_events", "messages"})
"""Those of which several robots have the sum; of everything else they have the mean."""


class ForagingState:
    """What is true in a block of worlds, flat: each robot, then the areas and the time.

    Of each robot: where it is, and what it believes; zeros for what it does not know, and for
    all beliefs where no hand-written estimator runs.
    """

    infos = INFOS
    counts = COUNTS

    def __init__(
        self,
        world: ForagingWorld,
        controller: Any,  # noqa: ANN401 of any kind
        agents: list[str],
        bounds: Bounds,
    ) -> None:
        """The truth about these worlds, whose robots have these names."""
        self._world = world
        self._controller = controller
        self._has_beliefs = "estimator" in controller.minds.dtype.names
        self._no_beliefs = Situation.array(world.robots.shape)
        self.layout = _layout(agents, bounds)
        self.space: Box = self.layout.box()

    def state(self, share_gone: Float64[Array, " worlds"]) -> Float32[Array, "worlds numbers"]:
        """One row for each world, as the layout says."""
        world = self._world
        robots = self._robots().reshape(world.n_worlds, -1)
        areas = world.worlds["areas"].reshape(world.n_worlds, -1)
        gone = np.minimum(share_gone, 1.0)[:, None]
        return np.concatenate([robots, areas, gone], axis=1, dtype=np.float32)

    @property
    def _situations(self) -> Array:
        """What every robot believes; nothing where no hand-written estimator runs."""
        if not self._has_beliefs:
            return self._no_beliefs
        situations: Array = self._controller.minds["estimator"]["situation"]
        return situations

    def log(self) -> Float64[Array, "rows infos"]:
        """The numbers that are logged, a row for each robot, in the order of INFOS."""
        numbers = np.empty((*self._world.robots.shape, len(INFOS)))
        write_log(self._world.robots, self._situations, self._world.worlds, numbers)
        return numbers.reshape(-1, len(INFOS))

    def _robots(self) -> Float32[Array, "rows numbers"]:
        """Pose, then beliefs in the world frame."""
        pose, beliefs = self._world.state.pose, rows(self._situations)
        x, y, theta = pose.T
        known = beliefs.known != 0
        parts = [
            np.stack([x, y, np.cos(theta), np.sin(theta)], axis=1),
            believed_places(pose, beliefs.areas, known).reshape(len(pose), 4),
            known,
            beliefs.p,
            goal_slots(beliefs.goal) * np.float32(self._has_beliefs),
        ]
        return np.concatenate(parts, axis=1, dtype=np.float32)


@entry_point
def write_log(
    robots: Array, situations: Array, worlds: Array, out: Float64[Array, "worlds robots infos"]
) -> None:
    """Write what is logged of each robot, in the order of INFOS."""
    for w in range(out.shape[0]):
        for i in range(out.shape[1]):
            robot, situation, row = robots[w, i], situations[w, i], out[w, i]
            n_known, error = 0, 0.0
            for area in range(2):
                if situation.known[area]:
                    n_known += 1
                    ahead, left = situation.areas[area, 0], situation.areas[area, 1]
                    dx, dy = to_outer(ahead, left, robot.heading[0], robot.heading[1])
                    x = robot.pose[0] + dx - worlds[w].areas[area, 0]
                    y = robot.pose[1] + dy - worlds[w].areas[area, 1]
                    error += np.hypot(x, y)
            row[0], row[1] = robot.round_trips, robot.lost_events
            row[2] = 1.0 if robot.known[0] and robot.known[1] else 0.0
            row[3], row[4] = robot.messages, n_known
            row[5] = error / max(n_known, 1)


def _layout(agents: list[str], bounds: Bounds) -> Layout:
    arena = bounds.scenario.arena
    half = {"x": 0.5 * arena.length, "y": 0.5 * arena.width}
    features = [feature for agent in agents for feature in _of_robot(agent, half, bounds)]
    features += [Feature(f"areas.{a}.{k}", "m", -half[k], half[k]) for a in AREAS for k in half]
    return Layout([*features, Feature("share_gone", "of the episode", 0.0, 1.0)])


def _of_robot(agent: str, half: dict[str, float], bounds: Bounds) -> list[Feature]:
    """One robot's part of the state."""
    far = bounds.believed
    found = [Feature(f"pose.{k}", "m", -half[k], half[k]) for k in half]
    found += [Feature(f"heading.{k}", "ratio", -1.0, 1.0) for k in ("cos", "sin")]
    found += [
        Feature(f"believed.{area}.{k}", "m", -half[k] - far, half[k] + far, scale=PLACE_SCALE)
        for area in AREAS
        for k in half
    ]
    found += [Feature(f"known.{area}", "0 or 1", *FLAG) for area in AREAS]
    found += [Feature(f"p.{area}", "m", 0.0, bounds.path, scale=PATH_SCALE) for area in AREAS]
    found += [Feature(f"goal.{goal}", "0 or 1", *FLAG) for goal in GOALS]
    return [replace(each, name=f"{agent}.{each.name}") for each in found]
