"""The global state of a foraging world, for centralised critics and for the logs."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
from gymnasium.spaces import Box

from swarm_forage_env.arrays import NEST, PREY, Array, Float32, Float64
from swarm_forage_env.compiler import entry_point, kernel
from swarm_forage_env.epuck.fault_record import KINDS, N_KINDS
from swarm_forage_env.epuck.records import AREAS
from swarm_forage_env.equations.elementary import cos_sin
from swarm_forage_env.equations.geometry import to_outer
from swarm_forage_env.foraging.areas import MOST_AREAS
from swarm_forage_env.foraging.metrics import localisation_error
from swarm_forage_env.foraging.records import PATH, PLACE, RobotState, Situation, WorldState
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.foraging.world import ForagingWorld
from swarm_forage_env.no_layers import has_estimators
from swarm_forage_env.record import Record
from swarm_forage_env.spaces import GOALS, Feature, Layout

INFOS = (
    "round_trips",
    "lost_events",
    "on_path",
    "messages",
    "known_areas",
    "localisation_error_m",
)
"""What is logged of each robot: counts of the episode so far, and how it stands. The error is
the mean over the kinds of area that it knows, 0 if none, each to the nearest of its kind."""

FLAG = 0.0, 1.0

WORTH = "round trips", 0.0, math.inf
"""Unit and bounds of what an area is worth."""

COUNTS = frozenset({"round_trips", "lost_events", "messages"})
"""Those of which several robots have the sum; of everything else they have the mean."""


class ForagingState:
    """What is true in a block of worlds, flat: each robot, then the areas and the time.

    The first nest and the first prey area are told in every scenario. Where the scenario lists its
    areas, so are what these two are worth and all other areas, in as many slots as a scenario has
    room for; slots without an area are zero.

    Of each robot: where it is, and what it believes; zeros for what it does not know, and for
    all beliefs where no hand-written estimator runs. Where robots may be faulty, also which faults
    are in effect.
    """

    infos = INFOS
    counts = COUNTS

    def __init__(
        self,
        world: ForagingWorld,
        controller: Any,  # noqa: ANN401 of any kind
        agents: list[str],
        scenario: Scenario,
    ) -> None:
        """The truth about these worlds, whose robots have these names."""
        self._world = world
        self._controller = controller
        self._has_beliefs = has_estimators(controller.minds)
        self._no_beliefs = Situation.array(world.robots.shape)
        self._has_faults = scenario.faults.is_any
        self._lists_areas = bool(scenario.task.areas)
        self.layout = _layout(agents, scenario)
        self.space: Box = self.layout.box()

    def state(self, share_gone: Float64[Array, " worlds"]) -> Float32[Array, "worlds numbers"]:
        """One row for each world, as the layout says."""
        out = np.empty((self._world.n_worlds, len(self.layout)), np.float32)
        robots, worlds = self._world.robots, self._world.worlds
        shows = self._has_beliefs, self._has_faults, self._lists_areas
        write_state(robots, self._situations, worlds, share_gone, shows, out)
        return out

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


@kernel
def put_truth(
    robot: RobotState,
    situation: Situation,
    has_beliefs: bool,
    out: Float32[Array, " numbers"],
    at: int,
) -> int:
    """Write a robot's pose, and its beliefs in the world frame; where the next goes."""
    x, y, theta = robot.pose[0], robot.pose[1], robot.pose[2]
    c, s = cos_sin(theta)
    out[at], out[at + 1], out[at + 2], out[at + 3] = x, y, c, s
    for area in range(2):
        known = situation.known[area] != 0
        dx, dy = to_outer(situation.areas[area, 0], situation.areas[area, 1], c, s)
        out[at + 4 + 2 * area] = x + dx if known else 0.0
        out[at + 5 + 2 * area] = y + dy if known else 0.0
        out[at + 8 + area] = 1.0 if known else 0.0
        out[at + 10 + area] = situation.p[area]
    for k in range(3):
        out[at + 12 + k] = situation.goal[k] if has_beliefs else 0.0
    return at + 15


@kernel
def put_faults(robot: RobotState, out: Float32[Array, " numbers"], at: int) -> int:
    """Write which faults of a robot are in effect; where the next goes."""
    for kind in range(N_KINDS):
        out[at + kind] = robot.fault.active[kind]
    return at + N_KINDS


@kernel
def put_areas(
    world: WorldState, lists_areas: bool, out: Float32[Array, " numbers"], at: int
) -> int:
    """Write where areas are now, and if the scenario lists them all of them; where the next goes.

    The first nest, the first prey area, their worths, and the slots of the others.
    """
    for area in range(2):
        out[at + 2 * area], out[at + 2 * area + 1] = world.areas[area, 0], world.areas[area, 1]
    at += 4
    if not lists_areas:
        return at
    out[at], out[at + 1] = world.worths[NEST], world.worths[PREY]
    at += 2
    for area in range(2, MOST_AREAS):
        is_there = area < world.n_areas
        for k in range(2):
            out[at + k] = world.areas[area, k] if is_there else 0.0
            out[at + 2 + k] = 1.0 if is_there and world.kinds[area] == k else 0.0
        out[at + 4] = world.worths[area] if is_there else 0.0
        at += 5
    return at


@entry_point
def write_state(
    robots: Array,
    situations: Array,
    worlds: Array,
    share_gone: Float64[Array, " worlds"],
    shows: tuple[bool, bool, bool],
    out: Float32[Array, "worlds numbers"],
) -> None:
    """Write the truth about each world: its robots, its areas, and the time.

    It shows the robots' beliefs, or zeros, their faults, or nothing, and all areas or two of them.
    """
    has_beliefs, has_faults, lists_areas = shows
    for w in range(out.shape[0]):
        at = 0
        for i in range(robots.shape[1]):
            at = put_truth(robots[w, i], situations[w, i], has_beliefs, out[w], at)
            if has_faults:
                at = put_faults(robots[w, i], out[w], at)
        at = put_areas(worlds[w], lists_areas, out[w], at)
        out[w, at] = min(share_gone[w], 1.0)


@kernel
def put_counts(robot: RobotState, row: Float64[Array, " infos"]) -> None:
    """Write those of INFOS that are counted, and no matter of belief."""
    row[0], row[1] = robot.round_trips, robot.lost_events
    row[2] = 1.0 if robot.known[0] and robot.known[1] else 0.0
    row[3] = robot.messages


@kernel
def put_log(
    robot: RobotState, situation: Situation, world: WorldState, row: Float64[Array, " infos"]
) -> None:
    """Write what is logged of a robot, in the order of INFOS."""
    n_known, error = 0, 0.0
    for area in range(2):
        if situation.known[area]:
            n_known += 1
            error += localisation_error(robot, situation, area, world)
    put_counts(robot, row)
    row[4] = n_known
    row[5] = error / max(n_known, 1)


@entry_point
def write_log(
    robots: Array, situations: Array, worlds: Array, out: Float64[Array, "worlds robots infos"]
) -> None:
    """Write what is logged of each robot, in the order of INFOS."""
    for w in range(out.shape[0]):
        for i in range(out.shape[1]):
            put_log(robots[w, i], situations[w, i], worlds[w], out[w, i])


def _layout(agents: list[str], scenario: Scenario) -> Layout:
    arena = scenario.arena
    half = {"x": 0.5 * arena.length, "y": 0.5 * arena.width}
    features = [feature for agent in agents for feature in _of_robot(agent, half, scenario)]
    features += [Feature(f"areas.{a}.{k}", "m", -half[k], half[k]) for a in AREAS for k in half]
    if scenario.task.areas:
        features += [Feature(f"areas.{a}.worth", *WORTH, scale=1.0) for a in AREAS]
        features += [each for k in range(2, MOST_AREAS) for each in _of_area(k, half)]
    return Layout([*features, Feature("share_gone", "of the episode", 0.0, 1.0)])


def _of_area(number: int, half: dict[str, float]) -> list[Feature]:
    """One of the other areas, or zeros."""
    found = [Feature(f"areas.{number}.{k}", "m", -half[k], half[k]) for k in half]
    found += [Feature(f"areas.{number}.{kind}", "0 or 1", *FLAG) for kind in AREAS]
    return [*found, Feature(f"areas.{number}.worth", *WORTH, scale=1.0)]


def _of_robot(agent: str, half: dict[str, float], scenario: Scenario) -> list[Feature]:
    """One robot's part of the state."""
    found = [Feature(f"pose.{k}", "m", -half[k], half[k]) for k in half]
    found += [Feature(f"heading.{k}", "ratio", -1.0, 1.0) for k in ("cos", "sin")]
    found += [
        Feature(f"believed.{area}.{k}", "m", -math.inf, math.inf, scale=PLACE["scale"])
        for area in AREAS
        for k in half
    ]
    found += [Feature(f"known.{area}", "0 or 1", *FLAG) for area in AREAS]
    found += [Feature(f"p.{area}", "m", 0.0, math.inf, scale=PATH["scale"]) for area in AREAS]
    found += [Feature(f"goal.{goal}", "0 or 1", *FLAG) for goal in GOALS]
    if scenario.faults.is_any:
        found += [Feature(f"fault.{kind}", "0 or 1", *FLAG) for kind in KINDS]
    return [replace(each, name=f"{agent}.{each.name}") for each in found]


@kernel
def log_beliefs(
    robot: RobotState, mind: Record, world: WorldState, row: Float64[Array, " infos"]
) -> None:
    """Write what is logged of a robot that believes something."""
    put_log(robot, mind.situation, world, row)  # type: ignore[attr-defined]  # every estimator has one


@kernel
def log_counts(
    robot: RobotState,
    mind: Record,
    world: WorldState,
    row: Float64[Array, " infos"],
) -> None:
    """Write what is logged of a robot of a policy of everything: it believes nothing."""
    put_counts(robot, row)
    row[4] = row[5] = 0.0
