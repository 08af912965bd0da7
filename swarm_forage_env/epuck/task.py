"""User-defined tasks of e-pucks: `EpuckTask`, which makes the `Task`.

Robots have the body, sensors, radio, contacts and faults of the e-puck, and no estimator: a motion,
or a policy of `learn="motion"`, uses the sensor readings. All APIs, commands and engines, and a
GPU, can run the task.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.compiler import kernel
from swarm_forage_env.episode import EpisodeKind
from swarm_forage_env.epuck.control import steer_world
from swarm_forage_env.epuck.drawing import bodies, walls
from swarm_forage_env.epuck.records import (
    Action,
    Command,
    EpuckState,
    EpuckWorldState,
    Heard,
    Readings,
)
from swarm_forage_env.epuck.scenario import EpuckScenario
from swarm_forage_env.epuck.surroundings import list_by_robots
from swarm_forage_env.epuck.world import EpuckWorld
from swarm_forage_env.equations.differential_drive import drive_to_wheels, drive_v1_to_wheels
from swarm_forage_env.global_state import GlobalState, TrajectoryColumn, TrajectoryKind
from swarm_forage_env.interface import Kernel
from swarm_forage_env.observed_fields import layout_of, paths
from swarm_forage_env.policy_interface import PolicyInterface, Steering
from swarm_forage_env.record import Record
from swarm_forage_env.scene import Scene, Stage, without_beliefs
from swarm_forage_env.spaces import Feature, Layout
from swarm_forage_env.task import TASKS, Task

WHEELS = paths("", "robots.action", Action, "wheels")
"""Fields that a policy of the motion writes."""


def slots(scenario: EpuckScenario) -> Mapping[str, int]:
    """Return the number of message slots observed in a scenario."""
    return {"slots": scenario.radio.slots}


def _drive(speed: str, command: Kernel) -> Steering:
    turn = Feature("drive.turn", "of the sharpest turn, to the left", -1.0, 1.0)
    choices = (1.0, 0.0), (1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)
    return Steering(Layout((Feature("drive.speed", speed, -1.0, 1.0), turn)), choices, command)


STEERINGS = {
    "drive": _drive("-1 stands, 0 is the cruise speed", drive_to_wheels),
    "drive-v1": _drive("-1 stands, 1 is the cruise speed", drive_v1_to_wheels),
    "wheels": Steering(
        layout_of(WHEELS, {}, None),
        choices=((1.0, 1.0), (0.5, 1.0), (1.0, 0.5), (-1.0, 1.0), (1.0, -1.0)),
    ),
}
"""Forms of steering by the value of `action`; the first is the default."""

MOTION = PolicyInterface(
    (
        *paths("readings", "robots.readings", Readings, "proximity ground"),
        *paths("heard", "robots.heard", Heard, "is_valid range_bearing"),
        *paths("command", "robots.command", Command, "wheels"),
    ),
    WHEELS,
    ("motion",),
    slots,
    decision_period=10,
    can_correct=True,
)
"""Policy interface of the motion of a robot without an estimator: sensors and radio."""


DRIVING = ("driving", "", "", "", "")
"""States of a robot without an estimator, by the codes of `Scene.activity`."""

ON_GPU: Mapping[str, Kernel] = {"list_neighbours": list_by_robots}
"""Functions that replace those of a CPU on a GPU."""


@kernel
def log_messages(
    robot: EpuckState, mind: Record, world: EpuckWorldState, row: Float64[Array, " infos"]
) -> None:
    """Log the number of messages that a robot has received."""
    row[0] = robot.messages


@dataclass(frozen=True, kw_only=True)
class EpuckTask:
    """Definition of a task of e-pucks."""

    name: str
    scenario: type[EpuckScenario]
    """Parameters of a world; its part `task` holds those of the task."""
    world: type[EpuckWorld]
    """World with its records and the functions of its tick: see `epuck.tick`."""
    controller: str
    """Default controller."""
    episode: EpisodeKind
    """Metrics of an episode."""
    headings: tuple[str, str]
    """Names of the score and of the share that a picture shows."""
    shown: Callable[[Any, int], tuple[Array, float]]
    """Returns the integer score of each robot of one world, and a share in [0, 1]."""

    infos: tuple[str, ...] = ("messages",)
    """Names of the logged values of each robot."""
    log: Kernel = log_messages
    """Writes the logged values; arguments: robot, its estimator record, world and output row."""

    def register(self) -> Task:
        """Make the `Task`, register it under its name and return it."""
        task = Task(
            name=self.name,
            family="epuck",
            scenario=self.scenario,
            world=self.world,
            decide=steer_world,
            physics="rigid",
            controller=self.controller,
            agent="epuck",
            steered_by=("robots.readings", "robots.heard"),
            policies={"motion": MOTION},
            steerings=STEERINGS,
            gpu=ON_GPU,
            global_state=partial(SwarmState, self.infos, self.log),
            episode=self.episode,
            drawing=(self._stage, self._scene),
            trajectory=TRAJECTORY,
        )
        return TASKS.register(self.name)(task)

    def _stage(self, scenario: EpuckScenario, controller: str) -> Stage:
        centres = scenario.areas
        return Stage(
            controller=controller,
            areas=centres,
            kinds=(0,) * len(centres),
            names=("",) * len(centres),
            area_radius=scenario.area_radius,
            states=DRIVING,
            believes=False,
            headings=self.headings,
            **walls(scenario),
        )

    def _scene(self, world: EpuckWorld, minds: Array, w: int = 0) -> Scene:
        score, share = self.shown(world, w)
        counted = {"round_trips": score.astype(np.int32), "on_path": float(share)}
        return Scene(**without_beliefs(world.n_robots) | bodies(world, w) | counted)


class SwarmState(GlobalState):
    """Global state of a block of worlds as one row each: the pose of each robot, and the time."""

    def __init__(self, infos: tuple[str, ...], log: Kernel, *of_worlds: Any) -> None:  # noqa: ANN401 as in the base
        """Make the global state of these worlds, with these logged values."""
        self.infos, self.logs = infos, (log, log)
        super().__init__(*of_worlds)

    def robot_features(self) -> list[Feature]:
        """Return the features of a robot: its position and heading."""
        arena = self._scenario.arena
        half = {"x": 0.5 * arena.length, "y": 0.5 * arena.width}
        place = [Feature(axis, "m", -far, far) for axis, far in half.items()]
        return [*place, *(Feature(name, "heading", -1.0, 1.0) for name in ("cos", "sin"))]

    def of_robots(self) -> list[Array]:
        """Return these features of all robots."""
        return [self._world.robots["pose"][:, :, :2], self._world.robots["heading"]]


def _take(world: EpuckWorld, minds: Array) -> Mapping[str, Array]:
    x, y, heading = np.moveaxis(world.robots["pose"], 2, 0)
    heard, reward = world.robots["heard"]["n"], world.robots["reward"]
    return {"x": x, "y": y, "heading": heading, "messages": heard, "reward": reward}


POSE_COLUMNS = (
    TrajectoryColumn("x", "f4", "true place along the arena [m], its centre is 0"),
    TrajectoryColumn("y", "f4", "true place across the arena [m]"),
    TrajectoryColumn("heading", "f4", "true heading [rad], -pi to pi, 0 along x"),
)
MESSAGES_COLUMN = TrajectoryColumn("messages", "i4", "messages that the robot heard in this tick")
REWARD_COLUMN = TrajectoryColumn("reward", "f4", "what the robot earned in this tick")

TRAJECTORY = TrajectoryKind((*POSE_COLUMNS, MESSAGES_COLUMN, REWARD_COLUMN), _take)
