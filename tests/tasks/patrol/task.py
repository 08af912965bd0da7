"""The task of patrol, as the rest of the house knows it."""

import math
from dataclasses import dataclass

from patrol.control import SCALE, Situation, decide_world
from patrol.scenario import PatrolScenario
from patrol.world import Action, PatrolWorld
from swarm_forage_env.compiler import kernel
from swarm_forage_env.episode import Episode, EpisodeKind, judged_at_the_end
from swarm_forage_env.global_state import GlobalState
from swarm_forage_env.observed_fields import paths
from swarm_forage_env.policy_interface import PolicyInterface
from swarm_forage_env.spaces import Feature
from swarm_forage_env.task import TASKS, Potential, Task


@kernel
def potential(robot, world):
    """The visits of a robot."""
    return float(robot.visits)


@kernel
def log_visits(robot, mind, world, row):
    """The visits of a robot."""
    row[0] = robot.visits


@dataclass(frozen=True, kw_only=True)
class PatrolEpisode(Episode):
    """The results of one episode."""

    visits_per_robot: float


class PatrolState(GlobalState):
    """Where each robot is, and how much of the episode is gone."""

    infos, logs = ("visits",), (log_visits, log_visits)
    counts = frozenset({"visits"})

    def robot_features(self):
        return [Feature(axis, "m", -math.inf, math.inf, scale=SCALE) for axis in "xy"]

    def of_robots(self):
        return [self._world.robots["pose"][:, :, :2]]


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
        judged_at_the_end(lambda world: {"visits_per_robot": world.robots["visits"].mean(axis=1)}),
        "visits_per_robot",
        "Visits per robot",
        {"visits_per_robot": ("visits a\nrobot", 1.0)},
    ),
)

TASKS.register(PATROL.name)(PATROL)
