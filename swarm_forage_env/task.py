"""Task: all that the rest of the house knows of a world.

`task_of` is the only place that asks what kind a scenario is. A task of one's own is a
folder whose module enters a `Task` in `TASKS`, and its scenarios in `SCENARIOS`.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from swarm_forage_env.arrays import Array, Bool, Float64
from swarm_forage_env.episode import EpisodeKind
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.interface import Controller, Kernel
from swarm_forage_env.parameters import Part
from swarm_forage_env.policy_interface import PolicyInterface
from swarm_forage_env.random_streams import checked_seed
from swarm_forage_env.record import rows
from swarm_forage_env.registry import Registry
from swarm_forage_env.scene import Scene, Stage


class World(Protocol):
    """A block of worlds of one task, as structured arrays."""

    scenario: Any
    """The scenario of the first world."""
    scenarios: tuple[Any, ...]
    """The scenario of every world: they differ in numbers only, not in how many robots."""
    n_worlds: int
    n_robots: int
    robots: Array
    """The truth about every robot, worlds by robots."""
    worlds: Array
    """Clock and numbers of every world."""

    @property
    def records(self) -> Any:  # noqa: ANN401 an array, or a tuple of arrays
        """What the templates `observe` and `decide` are handed first."""
        ...

    @property
    def is_over(self) -> Bool[Array, " worlds"]:
        """The scenario's time is up in each world."""
        ...

    def reset(self, seeds: Sequence[int]) -> None:
        """Start every world anew, each from its seed."""
        ...

    def tick(self, first: int, last: int) -> None:
        """Carry out the commands in the worlds first .. last - 1."""
        ...


class Block(ABC):
    """Worlds of one task that run side by side: what `World` asks for and no task differs in."""

    robots: Array
    worlds: Array

    def __init__(self, scenarios: Sequence[Any], seeds: Sequence[int]) -> None:
        """One world for each seed, of one scenario each; all have the same number of robots."""
        self.scenario, self.scenarios = scenarios[0], tuple(scenarios)
        self.n_worlds, self.n_robots = len(seeds), _n_robots(scenarios)

    @property
    def rows(self) -> int:
        """Robots in all worlds."""
        return self.robots.size

    @property
    def state(self) -> Any:  # noqa: ANN401 a recarray
        """The truth with a row for each robot of every world; `state.pose` is a column of it."""
        return rows(self.robots)

    @property
    def is_over(self) -> Bool[Array, " worlds"]:
        """The scenario's time is up in each world."""
        n_ticks = [scenario.n_ticks for scenario in self.scenarios]
        return np.asarray(self.worlds["ticks"] >= n_ticks)

    def reset(self, seeds: Sequence[int]) -> None:
        """Start every world anew, each from its seed."""
        if len(seeds) != self.n_worlds:
            raise ConfigError(f"seeds={list(seeds)}: must be {self.n_worlds}, one for each world")
        for w, seed in enumerate(seeds):
            self.restart(w, checked_seed(seed))
        self.sense_first()

    @abstractmethod
    def restart(self, which: int, seed: int) -> None:
        """Put one world's robots at their starting places and its streams at their seed."""

    @abstractmethod
    def sense_first(self, first: int = 0, last: int | None = None) -> None:
        """Sense before the first tick, in the worlds first .. last - 1."""


def _n_robots(scenarios: Sequence[Any]) -> int:
    """How many robots there are in each world; ConfigError if not equally many."""
    numbers = sorted({scenario.task.n_robots for scenario in scenarios})
    if len(numbers) > 1:
        raise ConfigError(f"task.n_robots={numbers}: must be the same in all worlds of a block")
    return int(numbers[0])


@dataclass(frozen=True, kw_only=True)
class Task:
    """One kind of world, with all that is particular to it."""

    name: str
    scenario: type[Part]
    """What its scenarios are: they have a `name`, a `tick` [s], `n_ticks`, and a part `task` with
    `n_robots` and `duration` [s]."""

    world: Callable[[Sequence[Any], Sequence[int], str], World]
    """Makes a block of worlds from a scenario and a seed for each, and the engine's name."""

    decide: Kernel
    """Template of the second half of a tick, after the cut."""

    physics: str
    """Engine where none is asked for."""

    controller: str
    """Controller where none is asked for."""

    agent: str
    """What its robots are called: `epuck_0`, `epuck_1`, ..."""

    commanded: str
    """The field of a robot's command, and of its action, that the motion layer writes."""

    exchange: Callable[[Any, Array], Any]
    """What the weighting layer sees, from the world and the minds of its robots."""

    situation: Callable[[Any, Array], Any]
    """What the motion layer sees, from the world and the minds of its robots."""

    array_weighting: Callable[..., Any]
    """Makes a rule on arrays of a compiled `WeightingLayer`: hand-written, driven from outside."""

    array_motion: Callable[..., Any]
    """The same of a `MotionLayer`, a scenario and seeds."""

    policies: Mapping[str, PolicyInterface]
    """What a policy can take the place of, by the name that `learn` takes."""

    residuals: tuple[str, ...] = ()
    """Those of them that can be learned as a correction of the hand-written motion."""

    is_joint: bool = False
    """Robots correct their estimates jointly, so that all of a swarm need the same estimator."""

    no_layers: Controller | None = None
    """What runs where a policy is everything; None: the task has no such policy."""

    bounds: Callable[[Any, int, float], Any]
    """How large numbers get: from a scenario, so many ticks, and the path that a message costs."""

    potential: Callable[[Any], Callable[[], Float64[Array, " rows"]]]
    """Makes the potential of every robot of a block of worlds, for shaping."""

    global_state: Callable[[Any, Any, list[str], Any], Any]
    """Makes what centralised critics and logs are told, from world, controller, names, bounds."""

    episode: EpisodeKind
    """What an episode is judged by."""

    stage: Callable[[Any, str], Stage] | None = None
    """What stands still in a picture, from a scenario and what moves the robots; None: the task
    has no drawing."""

    scene: Callable[[Any, Array, int], Scene] | None = None
    """What is drawn of one world, from a block of them, the minds of its robots and which."""


TASKS: Registry[Task] = Registry(
    "task", ("swarm_forage_env.foraging.task", "swarm_forage_env.waypoints.task")
)
"""Tasks by name; the two built-in ones are imported when any is asked for."""


def task_of(scenario: Any) -> Task:  # noqa: ANN401 whatever was given
    """The task that a scenario belongs to; ConfigError if it is none."""
    for task in _tasks():
        if isinstance(scenario, task.scenario):
            return task
    raise ConfigError(f"scenario={scenario!r}: must be a name, a TOML file or a Scenario")


def task_of_episode(episode: Any) -> Task:  # noqa: ANN401 whatever was given
    """The task that an episode is of; ConfigError if it is of none."""
    for task in _tasks():
        if isinstance(episode, task.episode.episode):
            return task
    raise ConfigError(f"{episode!r}: must be an episode of a task")


def _tasks() -> Iterator[Task]:
    """All tasks, those of plug-ins last: they are looked for when no other one fits."""
    yield from TASKS.loaded()
    yield from (TASKS[name] for name in TASKS)


def stage_of(scenario: Any, moved_by: str) -> Stage:  # noqa: ANN401 of any task
    """The stage of a scenario and of what moves its robots; ConfigError if it has no drawing."""
    task = task_of(scenario)
    if task.stage is None:
        raise ConfigError(
            f"scenario '{scenario.name}': the task {task.name} has no drawing; take one in which"
            " robots forage, as es1"
        )
    return task.stage(scenario, moved_by)
