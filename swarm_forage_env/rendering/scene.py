"""What is drawn of one world: its stage, which stands still, and a scene for each tick.

Plain numbers in the world frame; no drawing library is needed to take them or to read them.
"""

from dataclasses import dataclass

import numpy as np

from swarm_forage_env.arrays import Array, Bool, Float32, Float64, Int8, Int32, Int64, checked
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.interface import Heard, Situation
from swarm_forage_env.foraging.scoring import TO_NEST, TO_PREY
from swarm_forage_env.metrics import believed_places, on_path_now
from swarm_forage_env.scenario import Scenario
from swarm_forage_env.state import SwarmState
from swarm_forage_env.waypoints_scenario import AnyScenario
from swarm_forage_env.world import World

STATES = ("exploring", "to nest", "to prey", "lost", "talking")
"""What a robot is doing, in the order of the codes in `Scene.doing`."""

EXPLORING, TO_THE_NEST, TO_THE_PREY, LOST, TALKING = range(len(STATES))


@checked
@dataclass(frozen=True, slots=True)
class Stage:
    """What stays as it is for a whole episode."""

    scenario: str
    """Name of the scenario."""

    controller: str
    """What moves the robots, as the user named it."""

    length: float
    """Side of the arena along x [m]; its centre is the origin."""

    width: float
    """Side of the arena along y [m]."""

    areas: Float64[Array, "areas 2"]
    """True centres of nest and prey [m]."""

    area_radius: float
    """Radius of the nest and of the prey area [m]."""

    start_radius: float
    """Robots start with their centres in a circle of this radius about the origin [m]."""

    robot_radius: float
    """Radius of a robot's body [m]."""

    n_robots: int
    """Robots."""

    tick: float
    """Time between two scenes [s]."""

    duration: float
    """Length of the episode [s]."""


@checked
@dataclass(frozen=True, slots=True)
class Scene:
    """One world at one tick. Arrays are copies: the next tick leaves a scene as it is."""

    time: float
    """Since the start of the episode [s]."""

    pose: Float64[Array, "robots 3"]
    """x, y [m] and heading [rad]."""

    doing: Int8[Array, " robots"]
    """What each robot is doing, as a place in STATES.

    Lost: it once found itself lost, and neither saw an area nor was told of one since. Where no
    hand-written estimator runs, a robot is going where the task sends it next.
    """

    believed: Float64[Array, "robots areas 2"]
    """Where each robot believes the areas to be [m]; zeros where it does not know."""

    known: Bool[Array, "robots areas"]
    """The robot believes it knows where the area is."""

    p: Float32[Array, "robots areas"]
    """Inverse confidence: path travelled since the area was seen [m]; zeros where unknown."""

    messages: Int32[Array, "messages ends"]
    """Sender and receiver of every message heard in this tick."""

    round_trips: Int32[Array, " robots"]
    """Completed trips nest -> prey -> nest of each robot so far."""

    on_path: float
    """Share of the robots that is on the path now, as `metrics.on_path_now` defines it."""

    @property
    def total(self) -> int:
        """Round trips of all robots."""
        return int(self.round_trips.sum())


def stage_of(scenario: AnyScenario, controller: str) -> Stage:
    """The stage of a scenario on which robots forage, moved by what is named so.

    ConfigError for a scenario of waypoints: it has neither walls nor areas to draw.
    """
    if not isinstance(scenario, Scenario):
        raise ConfigError(
            f"scenario '{scenario.name}': only scenarios in which robots forage are drawn, as es1"
        )
    task, arena = scenario.task, scenario.arena
    return Stage(
        scenario=scenario.name,
        controller=controller,
        length=arena.length,
        width=arena.width,
        areas=scenario.areas,
        area_radius=task.area_radius,
        start_radius=task.start_radius,
        robot_radius=scenario.robot.radius,
        n_robots=task.n_robots,
        tick=scenario.tick,
        duration=scenario.n_ticks * scenario.tick,
    )


def scene_of(world: World, beliefs: Situation | None, which: int = 0) -> Scene:
    """One world of a block as it stands; without beliefs where no estimator keeps any.

    `scene_of(loop.world, loop.controller.estimator.situation)` for a `ControlLoop`, and
    `scene_of(batch.world, batch.cut.beliefs)` for a `Batch`.
    """
    state, n = world.state, world.n_robots
    rows = slice(which * n, (which + 1) * n)
    pose = state.pose[rows].copy()
    known, p = np.zeros((n, 2), np.bool_), np.zeros((n, 2), np.float32)
    believed = np.zeros((n, 2, 2))
    if beliefs is not None:
        known, p = beliefs.known[rows].copy(), beliefs.p[rows].copy()
        believed = believed_places(pose, beliefs.areas[rows], known)
    return Scene(
        time=float(state.ticks[which]) * world.scenario.tick,
        pose=pose,
        doing=_doing(state, beliefs, rows),
        believed=believed,
        known=known,
        p=p,
        messages=_messages(world.feedback.heard, rows),
        round_trips=state.round_trips[rows].copy(),
        on_path=float(on_path_now(state.known[rows], 1)[0]),
    )


def _doing(state: SwarmState, beliefs: Situation | None, rows: slice) -> Int8[Array, " robots"]:
    """The code of what each robot is doing; the last that holds is told."""
    doing = np.full(len(state.leg[rows]), EXPLORING, np.int8)
    if beliefs is None:
        doing[state.leg[rows] == TO_NEST] = TO_THE_NEST
        doing[state.leg[rows] == TO_PREY] = TO_THE_PREY
        return doing
    goal, talking = beliefs.goal[rows], beliefs.talking[rows]
    astray = (state.lost_events[rows] > 0) & ~state.known[rows].any(axis=1)
    doing[astray & (goal < 0)] = LOST
    doing[goal == 0] = TO_THE_NEST
    doing[goal == 1] = TO_THE_PREY
    doing[talking] = TALKING
    return doing


def _messages(heard: Heard, rows: slice) -> Int32[Array, "messages ends"]:
    """Sender and receiver of every valid slot, by receiver."""
    receiver, slot = np.nonzero(heard.valid[rows])
    sender: Int64[Array, " messages"] = heard.sender[rows][receiver, slot]
    return np.stack([sender, receiver], axis=1).astype(np.int32)
