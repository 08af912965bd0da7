"""EpuckWorld: a block of worlds of e-pucks, as structured arrays; a task says what they are for."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from swarm_forage_env.arrays import Array, Float64, Int32
from swarm_forage_env.compiler import bind, entry_point
from swarm_forage_env.epuck.fault_draws import name_faulty, write_fault_numbers
from swarm_forage_env.epuck.fault_record import Fault
from swarm_forage_env.epuck.obstacles import capsules_of
from swarm_forage_env.epuck.placing import place_world, place_worlds
from swarm_forage_env.epuck.records import EpuckState, EpuckWorldState
from swarm_forage_env.epuck.scenario import EpuckScenario
from swarm_forage_env.epuck.surroundings import FIRST, list_by_cells
from swarm_forage_env.epuck.tick import tick_world
from swarm_forage_env.equations import neighbours
from swarm_forage_env.equations.neighbours import EMPTY
from swarm_forage_env.equations.proximity import SENSING_RANGE
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.interface import Kernel
from swarm_forage_env.parameters import numbers_named
from swarm_forage_env.physics import ENGINES
from swarm_forage_env.task import World
from swarm_forage_env.ticks import nothing

SLACK = 0.02
"""Neighbours are listed this much beyond the reach [m], so that resolving contacts adds none."""

TICK: Mapping[str, Kernel] = {
    "tick_world": tick_world,
    "list_neighbours": list_by_cells,
    "begin_world": nothing,
    "begin_tick": nothing,
    "place_world": place_world,
}
"""What templates of worlds have free names for on a CPU; a task adds its functions."""

place_all = bind(place_worlds, {})
cells_of = entry_point(neighbours.cells_of)


class EpuckWorld(World):
    """Worlds that run side by side, each from its own seed and under its own numbers.

    A world in a block goes through the same states as the same world alone, bit for bit.
    """

    scenarios: tuple[EpuckScenario, ...]
    robot_kind: type[EpuckState]
    world_kind: type[EpuckWorldState]
    task_functions: Mapping[str, Kernel]

    def __init_subclass__(
        cls, robot: type[EpuckState], world: type[EpuckWorldState], functions: Mapping[str, Kernel]
    ) -> None:
        """The records of robots and worlds, with what a task adds, and the functions of its tick.

        `epuck.tick` says which; `begin_world` and `begin_tick` may be left out, and do nothing.
        ConfigError for others, which no tick would call, and without those that it calls.
        """
        if wrong := functions.keys() - {"begin_world", "begin_tick"} ^ {"brightness_at", "score"}:
            raise ConfigError(
                f"functions of {cls.__name__}: {', '.join(sorted(wrong))} unknown or missing; must"
                " be brightness_at and score, and begin_world or begin_tick where need be"
            )
        cls.robot_kind, cls.world_kind, cls.task_functions = robot, world, functions

    def __init__(
        self, scenarios: Sequence[EpuckScenario], seeds: Sequence[int], physics: str = "rigid"
    ) -> None:
        """One world for each scenario, whose robots start from its seed: nobody has sensed yet.

        The scenarios have the same number of robots. Without seeds nobody has a place.
        """
        super().__init__(scenarios)
        shape = (self.n_worlds, self.n_robots)
        n_slots = max(scenario.radio.slots for scenario in scenarios)
        self.robots = np.zeros(shape, self.robot_kind.dtype(slots=n_slots))
        """The truth about every robot; writing to it changes the worlds."""
        self.faults = np.zeros(shape, Fault.dtype())
        """What is wrong with every robot, or will be."""
        self.worlds = self.world_kind.array((self.n_worlds,))
        """Clock and numbers of every world."""
        self.near: Int32[Array, "worlds robots columns"] = np.zeros((*shape, FIRST), np.int32)
        """Who is near whom, as `find_neighbours` lists it."""
        self.obstacles: Float64[Array, "worlds obstacles 5"] = np.zeros((self.n_worlds, 0, 5))
        """Capsules of every world, as many as `n_obstacles` of it says; zeros after them."""
        self._cells: Int32[Array, "worlds cells"] = np.zeros((self.n_worlds, 0), np.int32)
        places = np.zeros(shape, np.uint64), np.zeros((*shape, 3))
        first_robot = self.robot_kind.array((1,), slots=n_slots)
        self.starts = first_robot, np.zeros(self.n_worlds, np.uint64), *places
        self.replace_scenarios(range(self.n_worlds), scenarios)
        self._physics = ENGINES[physics](scenarios)
        self.is_compiled = not hasattr(self._physics, "move")
        if len(seeds) > 0:
            self.reset(seeds)

    @staticmethod
    def write_task(scenario: Any, out_worlds: Array) -> None:  # noqa: ANN401 of its task
        """Write the numbers that the task adds to the records of worlds of a scenario."""

    def write_parameters(self, first: int, last: int) -> None:
        """Write the numbers of these worlds' scenario, and make room for neighbours and cells."""
        scenario, worlds = self.scenarios[first], self.worlds[first:last]
        if scenario.faults.is_any or worlds["has_faults"].any():
            name_faulty(scenario, self.faults[first:last])
        write_numbers(scenario, worlds)
        self.write_task(scenario, worlds)
        self.near = _widened(self.near, FIRST + max_neighbours(scenario), 0)
        reach, arena = reach_of(scenario), scenario.arena
        n_cells = cells_of(arena.length, reach) * cells_of(arena.width, reach)
        self._cells = _widened(self._cells, n_cells, EMPTY)
        standing = capsules_of(scenario.obstacles, scenario.arena.corners)
        self.obstacles = _widened(self.obstacles, len(standing), 0, axis=1)
        self.obstacles[first:last, : len(standing)] = standing

    def restart(self, first: int, last: int, seeds: Sequence[int]) -> None:
        """Put the robots at their starting places and their streams at the seeds of the worlds."""
        self.starts[1][first:last] = seeds
        place_all(self.arrays[:7], self.starts, self.trouble, first, last)
        for w in range(first, last):
            self._physics.reset(w, self.scenarios[w])

    @property
    def arrays(self) -> tuple[Array, ...]:
        """The arrays that the templates of a tick are handed."""
        own = self.robots, self.worlds, self.near, self._cells, self.obstacles
        return (*own, self.earned, self.faults, *self._physics.arrays)

    @property
    def functions(self) -> Mapping[str, Kernel]:
        """What `run_ticks` has free names for."""
        return {**TICK, **self.task_functions, "move_world": self._physics.move_world}

    def move(self, first: int, last: int) -> None:
        """Let an engine in Python move the robots of the worlds first .. last - 1."""
        if not self.is_compiled:
            engine: Any = self._physics
            engine.move(self.robots, self.worlds, self.near, self.obstacles, first, last)

    def snapshot(self) -> dict[str, Any]:
        """All that the next ticks depend on: arrays, scenarios, and what the engine remembers."""
        return super().snapshot() | {"_physics": self._physics.snapshot()}

    def restore(self, kept: Mapping[str, Any]) -> None:
        """Go on as when that snapshot was taken."""
        super().restore({name: each for name, each in kept.items() if name != "_physics"})
        self._physics.restore(kept["_physics"], self.scenarios)


def _widened(table: Array, width: int, fill: int, axis: int = -1) -> Array:
    """A table at least so wide along an axis, columns if none is named: the same one if it is."""
    shape = list(table.shape)
    shape[axis] = more = max(0, width - table.shape[axis])
    added = np.full(shape, fill, table.dtype)
    return np.concatenate([table, added], axis=axis) if more else table


def reach_of(scenario: EpuckScenario) -> float:
    """Distance within which robots are listed as neighbours, centre to centre [m].

    The list is made before contacts are resolved, and an engine uses it in the next tick: until
    then two robots come nearer by the way that each drives, and by that which others push each of
    them, which is hardly more than these drive.
    """
    robot = scenario.robot
    touching, way = 2.0 * robot.radius, robot.cruise_speed * scenario.tick
    sensed = max(touching + SENSING_RANGE, scenario.radio.max_range) + SLACK
    return max(sensed, touching + 4.0 * way)


def max_neighbours(scenario: EpuckScenario) -> int:
    """Neighbours for which there is room: twice as many as discs can be without overlapping."""
    discs = ((reach_of(scenario) + scenario.robot.radius) / scenario.robot.radius) ** 2
    return min(max(1, scenario.task.n_robots - 1), 2 * math.ceil(discs) + 8)


def write_numbers(scenario: EpuckScenario, out_worlds: Array | np.void) -> None:
    """Write the numbers of a scenario to the records of its worlds, as kernels read them."""
    noise, cruise_speed = scenario.sensors.wheel_noise, scenario.robot.cruise_speed
    numbers = {
        **numbers_named(scenario, EpuckWorldState.fields),
        "dt": scenario.tick,
        "arena": (scenario.arena.length, scenario.arena.width),
        "encoder_error": noise * cruise_speed * scenario.tick,
        "is_board": scenario.radio.is_board,
        "slots": scenario.radio.slots,
        "full_reception_range": scenario.radio.near,
        "reach": reach_of(scenario),
        "n_obstacles": len(capsules_of(scenario.obstacles, scenario.arena.corners)),
        "has_faults": scenario.faults.is_any,
    }
    for name, value in numbers.items():
        out_worlds[name] = value
    write_fault_numbers(scenario, out_worlds["faults"])
