"""The task of patrol, as the rest of the house knows it."""

import math
from dataclasses import dataclass

from patrol.control import SCALE, Situation, decide_world
from patrol.scenario import PatrolScenario
from patrol.world import Action, PatrolWorld
from swarm_forage_env.compiler import kernel
from swarm_forage_env.episode import EpisodeKind
from swarm_forage_env.global_state import GlobalState
from swarm_forage_env.observed_fields import paths
from swarm_forage_env.policy_interface import PolicyInterface
from swarm_forage_env.spaces import Feature
from swarm_forage_env.task import TASKS, Potential, Task


@kernel
def potential(robot, world):
    """The visits of a robot."""
    return float(robot.visits)


@dataclass(frozen=True)
class PatrolEpisode:
    """The results of one episode."""

    scenario: str
    controller: str
    seed: int
    physics: str
    n_robots: int
    duration_s: float
    visits_per_robot: float
    wall_s: float


class PatrolMeter:
    """Counts the visits of each world."""

    def __init__(self, loop):
        self._world = loop.world

    def next_sample(self, tick):
        """There is nothing to measure on the way."""
        return tick + 1_000_000

    def sample(self, tick):
        """The end is read in `results`."""

    def results(self):
        visits = self._world.robots["visits"].mean(axis=1)
        return [{"visits_per_robot": float(each)} for each in visits]


class PatrolState(GlobalState):
    """Where each robot is, and how much of the episode is gone."""

    infos = ("visits",)
    counts = frozenset({"visits"})

    def robot_features(self):
        return [Feature(axis, "m", -math.inf, math.inf, scale=SCALE) for axis in "xy"]

    def of_robots(self):
        return [self._world.robots["pose"][:, :, :2]]

    def log(self):
        return self._world.robots["visits"].reshape(-1, 1).astype(float)


PATROL = Task(
    name="patrol",
    scenario=PatrolScenario,
    world=PatrolWorld,
    decide=decide_world,
    controller="patrol-ahead",
    agent="guard",
    policies={
        "motion": PolicyInterface(
            paths("situation", "minds.estimator.situation", Situation, "place"),
            paths("", "robots.action", Action, "wheels"),
            ("motion",),
        )
    },
    potential=Potential(potential),
    global_state=PatrolState,
    episode=EpisodeKind(
        PatrolEpisode,
        PatrolMeter,
        "visits_per_robot",
        "Visits per robot",
        {"visits_per_robot": ("visits a\nrobot", 1.0)},
    ),
)

TASKS.register(PATROL.name)(PATROL)
