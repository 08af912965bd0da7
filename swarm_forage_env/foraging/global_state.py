"""Reports of a foraging world: global state for critics, logs, and trajectories."""

import math
from collections.abc import Mapping

import numpy as np

from swarm_forage_env.arrays import NEST, PREY, Array, Float64
from swarm_forage_env.compiler import kernel
from swarm_forage_env.epuck.fault_record import KINDS
from swarm_forage_env.epuck.records import AREAS
from swarm_forage_env.epuck.task import MESSAGES_COLUMN, POSE_COLUMNS
from swarm_forage_env.foraging.areas import MAX_AREAS
from swarm_forage_env.foraging.control import Mind
from swarm_forage_env.foraging.metrics import localisation_error
from swarm_forage_env.foraging.records import RobotState, Situation, WorldState
from swarm_forage_env.foraging.world import ForagingWorld
from swarm_forage_env.global_state import GlobalState, TrajectoryColumn, TrajectoryKind
from swarm_forage_env.observed_fields import FieldPath, layout_of, paths
from swarm_forage_env.raw_control import has_estimators
from swarm_forage_env.spaces import GOALS, Feature

INFOS = ("round_trips", "lost_events", "on_path", "messages", "known_areas", "localisation_error_m")
"""Logged values of each robot: counts of the episode so far, and its current state. The error is
the mean over the kinds of area that it knows, 0 if none, each to the nearest area of its kind."""

BELIEFS = (
    FieldPath("", "", Situation, "areas", label="believed"),
    *paths("", "", Situation, "known p goal"),
)
"""Beliefs of a robot in the global state; the areas are in the world frame."""

FLAG = 0.0, 1.0
WORTH = "round trips", 0.0, math.inf
"""Unit and bounds of the worth of an area."""


@kernel
def log_counts(
    robot: RobotState, mind: Mind, world: WorldState, row: Float64[Array, " infos"]
) -> None:
    """Write those INFOS that do not depend on beliefs."""
    row[0], row[1] = robot.round_trips, robot.lost_events
    row[2] = 1.0 if robot.known[0] and robot.known[1] else 0.0
    row[3] = robot.messages


@kernel
def log_beliefs(
    robot: RobotState, mind: Mind, world: WorldState, row: Float64[Array, " infos"]
) -> None:
    """Write all INFOS of a robot with an estimator."""
    n_known, error = 0, 0.0
    for area in range(2):
        if mind.situation.known[area]:
            n_known += 1
            error += localisation_error(robot, mind.situation, area, world)
    log_counts(robot, mind, world, row)
    row[4] = n_known
    row[5] = error / max(n_known, 1)


class ForagingState(GlobalState):
    """Global state of a block of worlds, one row each: the robots, then the areas and the time.

    Each robot has its pose and its beliefs; beliefs are zero for unknown areas, and if no
    hand-written estimator runs. If robots may be faulty, the faults in effect are included.

    The first nest and the first prey area are in the state of every scenario. If the scenario lists
    its areas, their worths are included, and all other areas in MAX_AREAS slots; empty ones are 0.
    """

    infos, logs = INFOS, (log_counts, log_beliefs)
    counts = frozenset({"round_trips", "lost_events", "messages"})

    def robot_features(self) -> list[Feature]:
        """Return the features of one robot: pose, beliefs and faults."""
        half = self._half
        features = [Feature(f"pose.{k}", "m", -half[k], half[k]) for k in half]
        features += [Feature(f"heading.{k}", "ratio", -1.0, 1.0) for k in ("cos", "sin")]
        features += layout_of(BELIEFS, {}, None)
        if self._scenario.faults.is_any:
            features += [Feature(f"fault.{kind}", "0 or 1", *FLAG) for kind in KINDS]
        return features

    def of_robots(self) -> list[Array]:
        """Return these features of all robots."""
        robots = self._world.robots
        situations = Situation.array(robots.shape)
        if self._has_beliefs:
            situations = self._controller.minds["estimator"]["situation"]
        known, ahead, left = situations["known"] != 0, *np.moveaxis(situations["areas"], 3, 0)
        c, s = np.moveaxis(robots["heading"], 2, 0)[..., None]
        away = np.stack([c * ahead - s * left, s * ahead + c * left], axis=3)
        believed = robots["pose"][:, :, None, :2] + away
        return [
            robots["pose"][:, :, :2],
            robots["heading"],
            np.where(known[..., None], believed, 0.0),
            known,
            situations["p"],
            situations["goal"] if self._has_beliefs else np.zeros((*robots.shape, len(GOALS))),
            *([robots["is_faulty"]] if self._scenario.faults.is_any else []),
        ]

    def world_features(self) -> list[Feature]:
        """Return the features of the areas: two, or MAX_AREAS if the scenario lists its areas."""
        half = self._half
        features = [Feature(f"areas.{a}.{k}", "m", -half[k], half[k]) for a in AREAS for k in half]
        if not self._scenario.task.areas:
            return features
        features += [Feature(f"areas.{a}.worth", *WORTH, scale=1.0) for a in AREAS]
        for n in range(2, MAX_AREAS):
            features += [Feature(f"areas.{n}.{k}", "m", -half[k], half[k]) for k in half]
            features += [Feature(f"areas.{n}.{kind}", "0 or 1", *FLAG) for kind in AREAS]
            features += [Feature(f"areas.{n}.worth", *WORTH, scale=1.0)]
        return features

    def of_world(self) -> list[Array]:
        """Return these features of all areas."""
        worlds = self._world.worlds
        first, others = worlds["areas"][:, :2], worlds["areas"][:, 2:]
        if not self._scenario.task.areas:
            return [first]
        kinds, worths = worlds["kinds"][:, 2:, None], worlds["worths"][:, 2:, None]
        are_there = np.arange(2, MAX_AREAS)[:, None] < worlds["n_areas"][:, None, None]
        slots = np.concatenate([others, kinds == NEST, kinds == PREY, worths], axis=2)
        return [first, worlds["worths"][:, :2], np.where(are_there, slots, 0.0)]

    @property
    def _half(self) -> dict[str, float]:
        """Distance from the centre of the arena to its walls [m]."""
        arena = self._scenario.arena
        return {"x": 0.5 * arena.length, "y": 0.5 * arena.width}


FAULTS = tuple(
    "+".join(kind for bit, kind in enumerate(KINDS) if number >> bit & 1)
    for number in range(1, 1 << len(KINDS))
)
"""Name of every combination of faults; the index plus one is its bit mask."""


def take(world: ForagingWorld, minds: Array) -> Mapping[str, Array]:
    """Return the current trajectory columns of every robot."""
    robots = world.robots
    has_beliefs = has_estimators(minds)
    situation = minds["estimator"]["situation"] if has_beliefs else Situation.array(robots.shape)
    known = situation["known"] != 0
    bits = (robots["is_faulty"] != 0) @ (1 << np.arange(len(KINDS)))
    columns = (
        *np.moveaxis(robots["pose"], 2, 0),
        (situation["goal"] @ [0, 1, -1]).astype(np.int8),
        *np.moveaxis(known, 2, 0),
        *np.moveaxis(np.where(known, situation["p"], np.nan), 2, 0),
        *(robots["heard"]["n"], robots["round_trips"], bits - 1),
    )
    return dict(zip(FORAGING_TRAJECTORY.names, columns, strict=True))


FORAGING_TRAJECTORY = TrajectoryKind(
    (
        *POSE_COLUMNS,
        TrajectoryColumn(
            "goal", "i1", "area that the robot goes to; empty: it has no goal", ("nest", "prey")
        ),
        TrajectoryColumn("known_nest", "?", "the robot believes it knows where a nest is"),
        TrajectoryColumn("known_prey", "?", "the same of a prey area"),
        TrajectoryColumn(
            "p_nest", "f4", "inverse confidence: path since the nest was seen [m]; empty: unknown"
        ),
        TrajectoryColumn("p_prey", "f4", "the same of the prey area [m]"),
        MESSAGES_COLUMN,
        TrajectoryColumn("round_trips", "i4", "round trips that it has completed so far"),
        TrajectoryColumn(
            "fault", "i1", "faults in effect, as liar or deaf+mute; empty: none", FAULTS
        ),
    ),
    take,
)
