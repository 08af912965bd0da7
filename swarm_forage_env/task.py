"""Task: all that the rest of the code knows of a world.

`task_of` is the only place that asks what kind a scenario is. A task of one's own is a
folder whose module enters a `Task` in `TASKS`, and its scenarios in `SCENARIOS`.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field
from functools import cached_property
from operator import attrgetter
from typing import Any

import numpy as np

from swarm_forage_env import ticks
from swarm_forage_env.arrays import Array, Bool, Float64, Int64
from swarm_forage_env.compiler import bind, typed_once
from swarm_forage_env.episode import EpisodeKind
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.global_state import GlobalState, TrajectoryKind
from swarm_forage_env.interface import Controller, Kernel, RunningController
from swarm_forage_env.parameters import BaseScenario
from swarm_forage_env.policy_interface import PolicyInterface, Steering
from swarm_forage_env.random_streams import checked_seed
from swarm_forage_env.record import Record, Rows, rows
from swarm_forage_env.registry import TASK_MODULES, Registry
from swarm_forage_env.scene import Scene, Stage
from swarm_forage_env.ticks import Modes, Trouble


class World(ABC):
    """A block of worlds of one task that run side by side, as structured arrays."""

    robots: Array
    """The truth about every robot, worlds by robots."""
    worlds: Array
    """Clock and numbers of every world."""
    scenarios: tuple[BaseScenario, ...]
    """The scenario of every world: they differ in numbers only, not in how many robots."""
    is_compiled = True
    """Nothing outside compiled code moves the robots."""

    starts: tuple[Array, ...]
    """What compiled code begins worlds from: the first record of a robot, the seed of each world,
    and room for the streams and the poses of its robots."""

    def __init__(self, scenarios: Sequence[BaseScenario]) -> None:
        self.scenarios = tuple(scenarios)
        self.n_worlds, self.n_robots = len(scenarios), _n_robots(scenarios)
        self.earned: Float64[Array, "worlds robots"] = np.zeros((self.n_worlds, self.n_robots))
        """What each robot has earned since somebody set it to 0."""
        self.trouble: Trouble = np.zeros(self.n_worlds + 1, np.int64)
        """What went wrong in each world, as `ticks.note` says."""
        self.modes: Modes = np.full(self.n_worlds, ticks.RUNS, np.int8)
        """What each world does in a call of `run_ticks`: it runs."""
        self.beginning: Modes = np.full(self.n_worlds, ticks.BEGINS, np.int8)
        """The modes of worlds that are to sense and observe before their first tick."""

    @property
    @abstractmethod
    def arrays(self) -> tuple[Array, ...]:
        """What the templates of a tick are handed: robots, and all that stands in the worlds."""

    @property
    @abstractmethod
    def functions(self) -> Mapping[str, Kernel]:
        """What `run_ticks` has free names for: the task's `tick_world`, the engine's
        `move_world`, and the functions that these name."""

    def move(self, first: int, last: int) -> None:  # noqa: B027 most worlds move in compiled code
        """Let an engine outside compiled code move the robots of the worlds first .. last - 1."""

    def tick(self, first: int, last: int) -> None:
        """Apply the commands in the worlds first .. last - 1, where no `Loop` does it."""
        self.move(first, last)
        self._tick_in(self.modes, first, last)

    def sense_first(self) -> None:
        """Sense before the first tick."""
        self._tick_in(self.beginning, 0, self.n_worlds)

    def _tick_in(self, modes: Modes, first: int, last: int) -> None:
        self._tick(self.arrays, (), modes, self.trouble, first, last, 1)
        self._check()

    def _check(self) -> None:
        if self.trouble[-1]:
            raise trouble_in(self, lambda w, robot: "")

    @cached_property
    def _tick(self) -> Kernel:
        return typed_once(bind(ticks.run_ticks, {**self.functions, **ticks.only("engine", "tick")}))

    @property
    def scenario(self) -> BaseScenario:
        """The scenario of the first world."""
        return self.scenarios[0]

    @property
    def rows(self) -> int:
        """Robots in all worlds."""
        return self.robots.size

    @property
    def state(self) -> Rows:
        """The truth with a row for each robot of every world; `state.pose` is a column of it."""
        return rows(self.robots)

    @property
    def is_over(self) -> Bool[Array, " worlds"]:
        """The scenario's time is up in each world."""
        n_ticks = [scenario.n_ticks for scenario in self.scenarios]
        return np.asarray(self.worlds["ticks"] >= n_ticks)

    def reset(self, seeds: Sequence[int], worlds: Sequence[int] | None = None) -> None:
        """Reset the worlds of these indices, or all, each to its seed; nobody has sensed yet.

        ConfigError, before anything changes, for what does not fit; and where robots find no room.
        """
        seed_of = self.seed_of(seeds, worlds)
        for first, last in consecutive([*seed_of], self.scenarios):
            self.restart(first, last, [seed_of[w] for w in range(first, last)])
        self._check()

    def seed_of(self, seeds: Sequence[int], worlds: Sequence[int] | None) -> dict[int, int]:
        """The seed of each of these worlds, or of all; ConfigError for what does not fit."""
        which = chosen_worlds(worlds, self.n_worlds).tolist()
        if len(seeds) != len(which):
            raise ConfigError(f"seeds={list(seeds)}: must be {len(which)}, one for each world")
        return dict(zip(which, map(checked_seed, seeds), strict=True))

    def replace_scenarios(self, which: Sequence[int], scenarios: Sequence[BaseScenario]) -> None:
        """Give worlds the numbers of other scenarios, one for each, which fit."""
        changed = dict(enumerate(self.scenarios)) | dict(zip(which, scenarios, strict=True))
        self.scenarios = tuple(changed.values())
        for first, last in consecutive(which, self.scenarios):
            self.write_parameters(first, last)

    @abstractmethod
    def write_parameters(self, first: int, last: int) -> None:
        """Go by the numbers of the one scenario that the worlds first .. last - 1 now have, from
        their restart on."""

    @abstractmethod
    def restart(self, first: int, last: int, seeds: Sequence[int]) -> None:
        """Put the robots of the worlds first .. last - 1, of one scenario, at their starting
        places, and the streams of each world at its seed."""

    def snapshot(self) -> dict[str, Any]:
        """All that the next ticks depend on: copies of all arrays, and the scenarios."""
        arrays = {name: each.copy() for name, each in self._arrays().items()}
        return {"scenarios": self.scenarios, **arrays}

    def restore(self, kept: Mapping[str, Any]) -> None:
        """Go on as when that snapshot was taken; arrays keep their place in memory, if their size
        is the same."""
        arrays = self._arrays()
        for name, each in kept.items():
            if name in arrays and arrays[name].shape == each.shape:
                arrays[name][...] = each
            else:
                setattr(self, name, copy(each))

    def _arrays(self) -> dict[str, Array]:
        return {name: each for name, each in vars(self).items() if isinstance(each, np.ndarray)}


def trouble_in(world: World, name_of: Callable[[int, int], str]) -> Exception:
    """What went wrong first in a block, as an error that names the robot's controller."""
    w = int(np.flatnonzero(world.trouble[:-1])[0])
    robot, kind = divmod(int(world.trouble[w]), ticks.N_TROUBLES)
    world.trouble[...] = ticks.NO_TROUBLE
    if kind == ticks.TOO_MANY_NEAR:
        return RuntimeError(
            f"world {w}: a robot has {robot} neighbours, more than discs of its radius can be"
            " without overlapping: contacts were not resolved"
        )
    if kind == ticks.NO_ROOM:
        return ConfigError(
            f"world {w}: the robots found no place in the start circle; enlarge task.start_radius"
        )
    if kind == ticks.REFUSED:
        return ConfigError(
            f"actions of world {w}: must be finite and within the action space; clip them first,"
            " as torch.clamp does"
        )
    commanded = task_of(world.scenario).commanded
    command = world.robots["command"][commanded][w, robot].tolist()
    return ConfigError(
        f"controller '{name_of(w, robot)}', tick {world.worlds['ticks'][w] + 1}, robot {robot}: its"
        f" {commanded} {command} are not finite, or a weight is not from 0 to 1; mend the layer or"
        " policy that gives them"
    )


def _n_robots(scenarios: Sequence[BaseScenario]) -> int:
    different = {id(each): each for each in scenarios}.values()
    numbers = sorted({scenario.task.n_robots for scenario in different})
    if len(numbers) > 1:
        raise ConfigError(f"task.n_robots={numbers}: must be the same in all worlds of a block")
    return int(numbers[0])


def chosen_worlds(worlds: object, n_worlds: int) -> Int64[Array, " chosen"]:
    """The numbers of the chosen worlds in their order, or all; ConfigError for what names none."""
    if worlds is None:
        return np.arange(n_worlds)
    chosen = np.asarray(worlds)
    if chosen.dtype == np.bool_ and chosen.shape == (n_worlds,):
        return np.flatnonzero(chosen)
    is_number = chosen.dtype.kind in "iu" and chosen.shape == np.unique(chosen).shape
    if is_number and ((chosen >= 0) & (chosen < n_worlds)).all():
        return chosen.astype(np.int64)
    raise ConfigError(
        f"worlds={worlds!r}: must be a mask of {n_worlds}, or different numbers from 0 to"
        f" {n_worlds - 1}"
    )


def consecutive(
    which: Sequence[int], scenarios: Sequence[object] | None = None
) -> list[tuple[int, int]]:
    """Runs of worlds that follow each other, in order: first and last + 1.

    With the scenarios of all worlds, those of a run have the same one.

    >>> consecutive([4, 0, 1])
    [(0, 2), (4, 5)]
    >>> consecutive([0, 1, 2], ["es1", "es1", "es2"])
    [(0, 2), (2, 3)]
    """
    runs: list[tuple[int, int]] = []
    for w in sorted(which):
        goes_on = runs and runs[-1][1] == w
        if goes_on and (scenarios is None or scenarios[w] is scenarios[w - 1]):
            runs[-1] = runs[-1][0], w + 1
        else:
            runs.append((w, w + 1))
    return runs


def check_fit(old: Sequence[BaseScenario], new: Sequence[BaseScenario]) -> None:
    """ConfigError if worlds of some scenarios cannot go on under others, one for each."""
    if len(new) != len(old):
        raise ConfigError(f"{len(new)} scenarios given for {len(old)} worlds: must be one for each")
    one_task((*old, *new))
    for before, after in zip(old, new, strict=True):
        for name in before.fixed:
            have, asked = map(attrgetter(name), (before, after))
            if asked != have:
                raise ConfigError(
                    f"{name}={asked} in the scenario '{after.name}': the world was made with"
                    f" {have}, by which its records have their sizes; keep that, or make new worlds"
                )


def one_task(scenarios: Sequence[BaseScenario]) -> "Task":
    """The task that all scenarios belong to; ConfigError if they belong to several."""
    first = task_of(scenarios[0])
    for scenario in {id(each): each for each in scenarios}.values():
        if (task := task_of(scenario)) is not first:
            raise ConfigError(
                f"scenarios '{scenarios[0].name}' of the task {first.name} and '{scenario.name}'"
                f" of the task {task.name}: all worlds of a block must be of one task"
            )
    return first


class Events(Record):
    """What happened to each robot in a tick, for rewards of the user's own; a task adds fields."""

    @staticmethod
    def write(world: Any, before: Array, out: Array) -> None:  # noqa: ANN401 of its task
        """Write the events of a tick of the worlds, whose robots were as `before` at its start."""
        raise NotImplementedError


@dataclass(frozen=True)
class Potential:
    """The potential of the robots of a task, for shaping."""

    of: Kernel
    """The potential Phi of one robot; of the robot and its world."""
    max_shaping: Callable[..., tuple[float, str]] = lambda scenario: (math.inf, "")
    """The largest weight of it that leaves a scenario as it is, and why."""


@dataclass(frozen=True, kw_only=True)
class Task:
    """One kind of world, with all that is particular to it."""

    name: str

    family: str = ""
    """Tasks of one family have the same records of what a layer sees: layers that are made for the
    family run in all of them."""
    scenario: type[BaseScenario]
    """What its scenarios are."""
    world: Callable[[Sequence[Any], Sequence[int], str], World]
    """Makes a block of worlds from a scenario and a seed for each, and the engine's name; without
    seeds nobody is placed before a reset."""

    decide: Kernel
    """The row template `decide_world`: the second half of the control, after the cut."""
    physics: str = "kinematic"
    """Default engine."""
    controller: str
    """Default controller."""
    agent: str = "robot"
    """What its robots are called: `epuck_0`, `epuck_1`, ..."""
    steered_by: tuple[str, ...] = ("robots.readings",)
    """Where the records lie that the motion layer sees between the situation and the last command,
    in the order in which `steer` takes them."""
    policies: Mapping[str, PolicyInterface]
    """What a policy can take the place of, by the name that `learn` takes; among it `motion`."""
    steerings: Mapping[str, Steering] = field(default_factory=dict)
    """How a policy can steer, by the name that `action` takes; the first is the usual one. None:
    as the action of its policies says."""
    is_joint: bool = False
    """Robots correct their estimates jointly, so that all of a swarm need the same estimator."""
    gpu: Mapping[str, Kernel] | None = None
    """Functions that a GPU binds to free names of the templates instead of a CPU's; None: the task
    runs on a CPU only."""
    raw_control: Controller | None = None
    """What runs where a policy is everything; None: the task has no such policy."""
    potential: Potential | None = None
    """The potential of a robot, for shaping; None: there is none."""
    global_state: Callable[[Any, RunningController, list[str], Any], GlobalState]
    """Makes the global state for critics and logs, from world, controller, names, scenario."""
    episode: EpisodeKind
    """What an episode is judged by."""
    events: type[Events] | None = None
    """What happened to each robot in a tick; None: not told."""
    drawing: tuple[Callable[[Any, str], Stage], Callable[[Any, Array, int], Scene]] | None = None
    """What stands still in a picture, from a scenario and what moves the robots; and what is drawn
    of one world, from a block of them, the minds of its robots and which. None: no drawing."""
    trajectory: TrajectoryKind | None = None
    """What is kept of its robots in every tick; None: nothing can be."""

    @property
    def commanded(self) -> str:
        """The field of a robot's command, and of its action, that the motion layer writes."""
        return self.policies["motion"].gives[0].name

    @property
    def residuals(self) -> tuple[str, ...]:
        """The policies that can be learned as a correction of the hand-written motion."""
        return tuple(name for name, each in self.policies.items() if each.can_correct)

    @property
    def scene(self) -> Callable[[Any, Array, int], Scene] | None:
        """Draws one world."""
        return self.drawing and self.drawing[1]

    def agents(self, n_robots: int) -> list[str]:
        """The names of n robots."""
        return [f"{self.agent}_{robot}" for robot in range(n_robots)]


TASKS: Registry[Task] = Registry("task", TASK_MODULES)
"""Tasks by name; the built-in ones are imported at the first use of one."""


def task_of(scenario: object) -> Task:
    """The task that a scenario belongs to; ConfigError if it is none."""
    for task in _tasks():
        if isinstance(scenario, task.scenario):
            return task
    raise ConfigError(f"scenario={scenario!r}: must be a name, a TOML file or a Scenario")


def task_of_episode(episode: object) -> Task:
    """The task that an episode is of; ConfigError if it is of none."""
    for task in _tasks():
        if isinstance(episode, task.episode.episode):
            return task
    raise ConfigError(f"{episode!r}: must be an episode of a task")


def _tasks() -> Iterator[Task]:
    """All tasks, those of plug-ins last: they are looked for when no other one fits."""
    yield from TASKS.loaded()
    yield from (TASKS[name] for name in TASKS)


def stage_of(scenario: BaseScenario, moved_by: str) -> Stage:
    """The stage of a scenario and of what moves its robots; ConfigError if it has no drawing."""
    task = task_of(scenario)
    if task.drawing is None:
        raise ConfigError(
            f"scenario '{scenario.name}': the task {task.name} has no drawing; take one that"
            " has, as es1 or waypoints-05"
        )
    return task.drawing[0](scenario, moved_by)
