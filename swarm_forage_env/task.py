"""Task: all that the rest of the house knows of a world.

`task_of(scenario)` is the only place that asks what kind a scenario is. A task of one's own is a
folder whose module enters a `Task` in `TASKS`, and its scenarios in `SCENARIOS`.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from swarm_forage_env.arrays import Array, Bool
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.interface import Kernel
from swarm_forage_env.parameters import Part
from swarm_forage_env.registry import Registry


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


@dataclass(frozen=True)
class Task:
    """One kind of world, with all that is particular to it."""

    name: str
    scenario: type[Part]
    """What its scenarios are."""

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


TASKS: Registry[Task] = Registry(
    "task", ("swarm_forage_env.foraging.task", "swarm_forage_env.waypoints.task")
)
"""Tasks by name; the two built-in ones are imported when any is asked for."""


def task_of(scenario: Any) -> Task:  # noqa: ANN401 whatever was given
    """The task that a scenario belongs to; ConfigError if it is none."""
    for name in TASKS:
        if isinstance(scenario, TASKS[name].scenario):
            return TASKS[name]
    raise ConfigError(f"scenario={scenario!r}: must be a name, a TOML file or a Scenario")
