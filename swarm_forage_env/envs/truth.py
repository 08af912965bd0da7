"""The whole truth about a world, for centralised critics and for the logs."""

import numpy as np
from gymnasium.spaces import Box

from swarm_forage_env.arrays import Array, Bool, Float32, Float64, Int32
from swarm_forage_env.envs.bounds import Bounds
from swarm_forage_env.envs.layout import GOALS, Layout, Slot, goal_slots
from swarm_forage_env.envs.observation import AREAS, FLAG
from swarm_forage_env.interface import Situation
from swarm_forage_env.compiler import kernel
from swarm_forage_env.metrics import believed_places, localisation_errors
from swarm_forage_env.world import World

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


class Truth:
    """What is true in a block of worlds, flat: each robot, then the areas and the time.

    Of each robot: where it is, and what it believes; zeros for what it does not know, and for
    all beliefs where no hand-written estimator runs.
    """

    def __init__(self, world: World, agents: list[str], bounds: Bounds) -> None:
        """The truth about these worlds, whose robots have these names."""
        self._world = world
        self._nowhere = np.zeros((world.rows, 2, 2), np.float32)
        self._nothing = np.zeros((world.rows, 2), np.bool_)
        self.layout = _layout(agents, bounds)
        self.space: Box = self.layout.box()

    def state(
        self, beliefs: Situation | None, share_gone: float
    ) -> Float32[Array, "worlds numbers"]:
        """One row for each world, as the layout says."""
        world = self._world
        robots = self._robots(beliefs).reshape(world.n_worlds, -1)
        rest = np.append(world.areas.ravel(), min(share_gone, 1.0))
        rests = np.broadcast_to(rest, (world.n_worlds, len(rest)))
        return np.concatenate([robots, rests], axis=1, dtype=np.float32)

    def log(self, beliefs: Situation | None) -> Float64[Array, "rows infos"]:
        """The numbers that are logged, a row for each robot, in the order of INFOS."""
        state, numbers = self._world.state, np.empty((self._world.rows, len(INFOS)))
        write_log(
            state.round_trips, state.lost_events, state.known, state.messages,
            state.pose, self._nowhere if beliefs is None else beliefs.areas,
            self._nothing if beliefs is None else beliefs.known, self._world.areas, numbers,
        )  # fmt: skip
        return numbers

    def _robots(self, beliefs: Situation | None) -> Float32[Array, "rows numbers"]:
        """Pose, then beliefs in the world frame."""
        x, y, theta = self._world.state.pose.T
        c, s = np.cos(theta), np.sin(theta)
        pose = np.stack([x, y, c, s], axis=1)
        if beliefs is None:
            ignorance = np.zeros((len(pose), 11), np.float32)
            return np.concatenate([pose, ignorance], axis=1, dtype=np.float32)
        place = believed_places(self._world.state.pose, beliefs.areas, beliefs.known)
        believed = place.reshape(len(pose), 4)
        goal = goal_slots(beliefs.goal)
        parts = [pose, believed, beliefs.known, beliefs.p, goal]
        return np.concatenate(parts, axis=1, dtype=np.float32)


@kernel
def write_log(  # noqa: PLR0913 inputs first, then the output
    round_trips: Int32[Array, " rows"],
    lost_events: Int32[Array, " rows"],
    reported: Bool[Array, "rows areas"],
    messages: Int32[Array, " rows"],
    pose: Float64[Array, "rows 3"],
    believed: Float32[Array, "rows areas 2"],
    known: Bool[Array, "rows areas"],
    areas: Float64[Array, "areas 2"],
    out_numbers: Float64[Array, "rows infos"],
) -> None:
    """What is logged, a row for each robot, in the order of INFOS."""
    error = np.zeros(known.shape)
    localisation_errors(pose, believed, known, areas, error)
    for i in range(pose.shape[0]):
        n_known = int(known[i, 0]) + int(known[i, 1])
        out_numbers[i, 0] = round_trips[i]
        out_numbers[i, 1] = lost_events[i]
        out_numbers[i, 2] = reported[i, 0] and reported[i, 1]
        out_numbers[i, 3] = messages[i]
        out_numbers[i, 4] = n_known
        out_numbers[i, 5] = (error[i, 0] + error[i, 1]) / max(n_known, 1)


def _layout(agents: list[str], bounds: Bounds) -> Layout:
    arena = bounds.scenario.arena
    half = {"x": 0.5 * arena.length, "y": 0.5 * arena.width}
    slots = [slot for agent in agents for slot in _robot_slots(agent, half, bounds)]
    slots += [Slot(f"areas.{a}.{k}", "m", -half[k], half[k]) for a in AREAS for k in half]
    return Layout([*slots, Slot("share_gone", "of the episode", 0.0, 1.0)])


def _robot_slots(agent: str, half: dict[str, float], bounds: Bounds) -> list[Slot]:
    """One robot's part of the state."""
    rows = [(f"pose.{k}", "m", -half[k], half[k]) for k in half]
    rows += [(f"heading.{k}", "ratio", -1.0, 1.0) for k in ("cos", "sin")]
    for area in AREAS:
        rows += [
            (f"believed.{area}.{k}", "m", -half[k] - bounds.believed, half[k] + bounds.believed)
            for k in half
        ]
    rows += [(f"known.{area}", "0 or 1", *FLAG) for area in AREAS]
    rows += [(f"p.{area}", "m", 0.0, bounds.path) for area in AREAS]
    rows += [(f"goal.{goal}", "0 or 1", *FLAG) for goal in GOALS]
    return [Slot(f"{agent}.{name}", unit, low, high) for name, unit, low, high in rows]
