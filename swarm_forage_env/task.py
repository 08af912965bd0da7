"""Tasks: the interface between a kind of world and the rest of the code.

Only `task_of` distinguishes kinds of scenarios. To add a task, write a package whose module
registers a `Task` in `TASKS` and its scenarios in `SCENARIOS`.
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
from swarm_forage_env.errors import ConfigError, shown
from swarm_forage_env.global_state import GlobalState, TrajectoryKind
from swarm_forage_env.interface import Controller, Kernel, RunningController
from swarm_forage_env.parameters import BaseScenario
from swarm_forage_env.policy_interface import PolicyInterface, Steering
from swarm_forage_env.random_streams import checked_seed
from swarm_forage_env.record import Record, Rows, rows
from swarm_forage_env.registry import TASK_MODULES, Registry
from swarm_forage_env.scene import Scene, Stage
from swarm_forage_env.ticks import Errors, Modes


class World(ABC):
    """A block of worlds of one task, simulated side by side in structured arrays."""

    robots: Array
    """Ground-truth record of each robot, shape (worlds, robots)."""
    worlds: Array
    """Record of each world: its clock and its parameters."""
    scenarios: tuple[BaseScenario, ...]
    """Scenario of each world; parameters may differ, but not the number of robots."""
    is_compiled = True
    """Whether compiled code alone moves the robots."""

    starts: tuple[Array, ...]
    """Arrays from which compiled code starts worlds: initial record of a robot, seed of each world,
    and buffers for the placement streams and the poses of its robots."""

    def __init__(self, scenarios: Sequence[BaseScenario]) -> None:
        self.scenarios = tuple(scenarios)
        self.n_worlds, self.n_robots = len(scenarios), _n_robots(scenarios)
        self.rewards: Float64[Array, "worlds robots"] = np.zeros((self.n_worlds, self.n_robots))
        """Reward that each robot has accumulated since the array was last set to 0."""
        self.errors: Errors = np.zeros(self.n_worlds + 1, np.int64)
        """Error code of each world, as `ticks.note` writes it; the last element flags any error."""
        self.modes: Modes = np.full(self.n_worlds, ticks.RUN, np.int8)
        """Mode of each world for `run_ticks`: RUN."""
        self.start_modes: Modes = np.full(self.n_worlds, ticks.START, np.int8)
        """Mode of each world for sensing and observing before the first tick: START."""

    @property
    @abstractmethod
    def arrays(self) -> tuple[Array, ...]:
        """Arrays of robots and worlds that the templates of a tick receive."""

    @property
    @abstractmethod
    def functions(self) -> Mapping[str, Kernel]:
        """Functions bound to the free names of `run_ticks`: the task's `tick_world`, the engine's
        `move_world`, and the functions that these call."""

    def move(self, first: int, last: int) -> None:  # noqa: B027 most worlds move in compiled code
        """Move the robots of worlds first .. last - 1 with an engine outside compiled code."""

    def tick(self, first: int, last: int) -> None:
        """Run one tick of worlds first .. last - 1 with the current commands, without a `Loop`."""
        self.move(first, last)
        self._tick_in(self.modes, first, last)

    def sense_first(self) -> None:
        """Compute the sensor readings before the first tick."""
        self._tick_in(self.start_modes, 0, self.n_worlds)

    def _tick_in(self, modes: Modes, first: int, last: int) -> None:
        self._tick(self.arrays, (), modes, self.errors, first, last, 1)
        self._check()

    def _check(self) -> None:
        if self.errors[-1]:
            raise error_in(self, lambda w, robot: "")

    @cached_property
    def _tick(self) -> Kernel:
        return typed_once(bind(ticks.run_ticks, {**self.functions, **ticks.only("engine", "tick")}))

    @property
    def scenario(self) -> BaseScenario:
        """The scenario of the first world."""
        return self.scenarios[0]

    @property
    def rows(self) -> int:
        """Number of robots in all worlds."""
        return self.robots.size

    @property
    def state(self) -> Rows:
        """View of `robots` with a row for each robot of every world; `state.pose` is a column."""
        return rows(self.robots)

    @property
    def is_over(self) -> Bool[Array, " worlds"]:
        """Whether the episode of each world has reached its last tick."""
        n_ticks = [scenario.n_ticks for scenario in self.scenarios]
        return np.asarray(self.worlds["ticks"] >= n_ticks)

    def reset(self, seeds: Sequence[int], worlds: Sequence[int] | None = None) -> None:
        """Reset the worlds of these indices, or all, each to its seed, without sensing.

        ConfigError, before any change, if seeds or indices do not fit; and if robots find no room.
        """
        seed_of = self.seed_of(seeds, worlds)
        for first, last in consecutive([*seed_of], self.scenarios):
            self.restart(first, last, [seed_of[w] for w in range(first, last)])
        self._check()

    def seed_of(self, seeds: Sequence[int], worlds: Sequence[int] | None) -> dict[int, int]:
        """Return the seed of each of these worlds, or all, by index; ConfigError for a misfit."""
        indices = chosen_worlds(worlds, self.n_worlds).tolist()
        if len(seeds) != len(indices):
            raise ConfigError(f"seeds={list(seeds)}: must be {len(indices)}, one for each world")
        return dict(zip(indices, map(checked_seed, seeds), strict=True))

    def replace_scenarios(self, worlds: Sequence[int], scenarios: Sequence[BaseScenario]) -> None:
        """Replace the scenarios of some worlds, one for each; `check_fit` must accept them."""
        changed = dict(enumerate(self.scenarios)) | dict(zip(worlds, scenarios, strict=True))
        self.scenarios = tuple(changed.values())
        for first, last in consecutive(worlds, self.scenarios):
            self.write_parameters(first, last)

    @abstractmethod
    def write_parameters(self, first: int, last: int) -> None:
        """Write the parameters of the scenario of worlds first .. last - 1 to their records; they
        apply from the next restart."""

    @abstractmethod
    def restart(self, first: int, last: int, seeds: Sequence[int]) -> None:
        """Place the robots of worlds first .. last - 1, which share a scenario, at their starting
        positions, and start the random streams of each world from its seed."""

    def snapshot(self) -> dict[str, Any]:
        """Return copies of all arrays, and the scenarios: all that the next ticks depend on."""
        arrays = {name: each.copy() for name, each in self._arrays().items()}
        return {"scenarios": self.scenarios, **arrays}

    def restore(self, snapshot: Mapping[str, Any]) -> None:
        """Restore a snapshot; arrays of unchanged shape are written in place."""
        arrays = self._arrays()
        for name, each in snapshot.items():
            if name in arrays and arrays[name].shape == each.shape:
                arrays[name][...] = each
            else:
                setattr(self, name, copy(each))

    def _arrays(self) -> dict[str, Array]:
        return {name: each for name, each in vars(self).items() if isinstance(each, np.ndarray)}


def error_in(world: World, name_of: Callable[[int, int], str]) -> Exception:
    """Return the error of the first world that has one as an exception, and clear all errors."""
    w = int(np.flatnonzero(world.errors[:-1])[0])
    robot, kind = divmod(int(world.errors[w]), ticks.N_ERRORS)
    world.errors[...] = ticks.NO_ERROR
    if kind == ticks.TOO_MANY_NEAR:
        return RuntimeError(
            f"world {w}: a robot has {robot} neighbours, more than discs of its radius can have"
            " without overlapping: the engine did not resolve contacts"
        )
    if kind == ticks.NO_ROOM:
        return ConfigError(
            f"world {w}: the robots found no place in the start circle; enlarge task.start_radius"
        )
    if kind == ticks.REFUSED:
        return ConfigError(
            f"actions of world {w}: must be finite and within the action space; clip them first"
            " with torch.clamp"
        )
    commanded = task_of(world.scenario).commanded
    command = world.robots["command"][commanded][w, robot].tolist()
    return ConfigError(
        f"controller '{name_of(w, robot)}', tick {world.worlds['ticks'][w] + 1}, robot {robot}:"
        f" its {commanded} {command} are not finite, or a weight is not from 0 to 1; correct the"
        " layer or policy that computes them"
    )


def _n_robots(scenarios: Sequence[BaseScenario]) -> int:
    different = {id(each): each for each in scenarios}.values()
    numbers = sorted({scenario.task.n_robots for scenario in different})
    if len(numbers) > 1:
        raise ConfigError(f"task.n_robots={numbers}: must be the same in all worlds of a block")
    return int(numbers[0])


def chosen_worlds(worlds: object, n_worlds: int) -> Int64[Array, " chosen"]:
    """Return the indices of the chosen worlds in order, or of all; ConfigError if invalid."""
    if worlds is None:
        return np.arange(n_worlds)
    chosen = np.asarray(worlds)
    if chosen.dtype == np.bool_ and chosen.shape == (n_worlds,):
        return np.flatnonzero(chosen)
    is_whole = chosen.dtype.kind in "iu" or chosen.size == 0  # NumPy takes [] for real numbers
    is_number = is_whole and chosen.shape == np.unique(chosen).shape
    if is_number and ((chosen >= 0) & (chosen < n_worlds)).all():
        return chosen.astype(np.int64)
    raise ConfigError(
        f"worlds={shown(worlds)}: must be a mask of {n_worlds} worlds, or different indices from 0"
        f" to {n_worlds - 1}"
    )


def consecutive(
    worlds: Sequence[int], scenarios: Sequence[object] | None = None
) -> list[tuple[int, int]]:
    """Return the runs of consecutive worlds, in order, each as (first, last + 1).

    If the scenarios of all worlds are given, the worlds of a run share one scenario.

    >>> consecutive([4, 0, 1])
    [(0, 2), (4, 5)]
    >>> consecutive([0, 1, 2], ["es1", "es1", "es2"])
    [(0, 2), (2, 3)]
    """
    runs: list[tuple[int, int]] = []
    for w in sorted(worlds):
        goes_on = runs and runs[-1][1] == w
        if goes_on and (scenarios is None or scenarios[w] is scenarios[w - 1]):
            runs[-1] = runs[-1][0], w + 1
        else:
            runs.append((w, w + 1))
    return runs


def check_fit(old: Sequence[BaseScenario], new: Sequence[BaseScenario]) -> None:
    """Raise ConfigError if worlds of the old scenarios cannot take the new ones, one for each."""
    if len(new) != len(old):
        raise ConfigError(f"{len(new)} scenarios given for {len(old)} worlds: must be one for each")
    one_task((*old, *new))
    for before, after in zip(old, new, strict=True):
        for name in before.fixed:
            made, wanted = map(attrgetter(name), (before, after))
            if wanted != made:
                raise ConfigError(
                    f"{name}={wanted} in the scenario '{after.name}': the world was made with"
                    f" {made}, which determines the sizes of its records; keep {made}, or make"
                    " new worlds"
                )


def one_task(scenarios: Sequence[BaseScenario]) -> "Task":
    """Return the task of all these scenarios; ConfigError if they belong to several."""
    first = task_of(scenarios[0])
    for scenario in {id(each): each for each in scenarios}.values():
        if (task := task_of(scenario)) is not first:
            raise ConfigError(
                f"scenarios '{scenarios[0].name}' of the task {first.name} and '{scenario.name}'"
                f" of the task {task.name}: all worlds of a block must be of one task"
            )
    return first


class Events(Record):
    """Record of the events of a robot in a tick, for user-defined rewards; tasks add fields."""

    @staticmethod
    def write(world: Any, before: Array, out: Array) -> None:  # noqa: ANN401 of its task
        """Write the events of the last tick; `before` holds the robot records at its start."""
        raise NotImplementedError


@dataclass(frozen=True)
class Potential:
    """Potential function of a task, for reward shaping."""

    of: Kernel
    """Potential Phi of one robot, computed from the records of the robot and its world."""
    max_shaping: Callable[..., tuple[float, str]] = lambda scenario: (math.inf, "")
    """Largest shaping weight allowed in a scenario, and the reason for the limit."""


@dataclass(frozen=True, kw_only=True)
class Task:
    """Definition of one kind of world."""

    name: str

    family: str = ""
    """Tasks of one family share the records that layers read, so that layers written for the family
    run in all of them."""
    scenario: type[BaseScenario]
    """Class of its scenarios."""
    world: Callable[[Sequence[Any], Sequence[int], str], World]
    """Creates a block of worlds from a scenario and a seed for each, and the name of an engine;
    without seeds, robots have no positions before a reset."""

    decide: Kernel
    """Row template `decide_world`: the second half of the control, after the cut."""
    physics: str = "kinematic"
    """Default engine."""
    controller: str
    """Default controller."""
    agent: str = "robot"
    """Prefix of the names of its robots, as in `epuck_0`, `epuck_1`, ..."""
    steered_by: tuple[str, ...] = ("robots.readings",)
    """Paths of the records that `steer` receives between the situation and the last command, in the
    order of its arguments."""
    policies: Mapping[str, PolicyInterface]
    """Policy interfaces by the name that `learn` takes; one of them is `motion`."""
    steerings: Mapping[str, Steering] = field(default_factory=dict)
    """Forms of steering by the name that `action` takes; the first is the default. If empty, the
    policy interface alone defines the action."""
    is_joint: bool = False
    """Whether robots correct their estimates jointly; all of a swarm then need one estimator."""
    gpu: Mapping[str, Kernel] | None = None
    """Functions that replace those of a CPU in templates bound for a GPU; None: the task runs on a
    CPU only."""
    raw_control: Controller | None = None
    """Controller for policies that replace all layers; None if the task has no such policy."""
    potential: Potential | None = None
    """Potential for reward shaping; None if the task has none."""
    global_state: Callable[[Any, RunningController, list[str], Any], GlobalState]
    """Creates the global state (critics, logs) from world, controller, agents and scenario."""
    episode: EpisodeKind
    """Result class, metrics and score of its episodes."""
    events: type[Events] | None = None
    """Record of the events of each robot in a tick; None if the task reports none."""
    drawing: tuple[Callable[[Any, str], Stage], Callable[[Any, Array, int], Scene]] | None = None
    """Two functions: one makes the `Stage` from a scenario and the controller's name, the other the
    `Scene` from a block of worlds, its `minds` and a world index. None: no drawing."""
    trajectory: TrajectoryKind | None = None
    """Columns recorded of its robots in every tick; None if nothing can be recorded."""

    @property
    def commanded(self) -> str:
        """Field of a robot's command, and of its action, that the motion layer writes."""
        return self.policies["motion"].gives[0].name

    @property
    def residuals(self) -> tuple[str, ...]:
        """Names of the policies that can be learned as a correction of the hand-written motion."""
        return tuple(name for name, each in self.policies.items() if each.can_correct)

    @property
    def scene(self) -> Callable[[Any, Array, int], Scene] | None:
        """Function that makes the scene of one world; None if there is no drawing."""
        return self.drawing and self.drawing[1]

    def agents(self, n_robots: int) -> list[str]:
        """Return the names of n robots."""
        return [f"{self.agent}_{robot}" for robot in range(n_robots)]


TASKS: Registry[Task] = Registry("task", TASK_MODULES)
"""Tasks by name; the modules of the built-in tasks are imported at first use."""


def task_of(scenario: object) -> Task:
    """Return the task that a scenario belongs to; ConfigError if it belongs to none."""
    for task in _tasks():
        if isinstance(scenario, task.scenario):
            return task
    raise ConfigError(f"scenario={shown(scenario)}: must be a name, a TOML file or a Scenario")


def task_of_episode(episode: object) -> Task:
    """Return the task that an episode belongs to; ConfigError if it belongs to none."""
    for task in _tasks():
        if isinstance(episode, task.episode.episode):
            return task
    raise ConfigError(f"{episode!r}: must be an episode of a task")


def _tasks() -> Iterator[Task]:
    """Yield the loaded tasks, then all: plug-ins are imported only if no loaded task fits."""
    yield from TASKS.loaded()
    yield from (TASKS[name] for name in TASKS)


def stage_of(scenario: BaseScenario, moved_by: str) -> Stage:
    """Return the stage of a scenario; `moved_by` names the controller. ConfigError: no drawing."""
    task = task_of(scenario)
    if task.drawing is None:
        raise ConfigError(
            f"scenario '{scenario.name}': the task {task.name} has no drawing; use a scenario"
            " that has one, such as es1 or waypoints-05"
        )
    return task.drawing[0](scenario, moved_by)
