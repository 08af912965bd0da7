"""EpuckWorld: a block of worlds of e-pucks as structured arrays, the base of all their tasks."""

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
"""Margin of the neighbour list [m], so that resolving contacts adds no neighbours."""

TICK: Mapping[str, Kernel] = {
    "tick_world": tick_world,
    "list_neighbours": list_by_cells,
    "begin_world": nothing,
    "begin_tick": nothing,
    "place_world": place_world,
}
"""Functions bound to the free names of templates on a CPU; a task adds its own."""

place_all = bind(place_worlds, {})
cells_of = entry_point(neighbours.cells_of)


class EpuckWorld(World):
    """Worlds in parallel, each with its own seed and parameters, and bit for bit as it is alone."""

    scenarios: tuple[EpuckScenario, ...]
    robot_kind: type[EpuckState]
    world_kind: type[EpuckWorldState]
    task_functions: Mapping[str, Kernel]

    def __init_subclass__(
        cls, robot: type[EpuckState], world: type[EpuckWorldState], functions: Mapping[str, Kernel]
    ) -> None:
        """Set the records of robots and worlds of a task, and the functions of its tick.

        `epuck.tick` describes these functions; `begin_world` and `begin_tick` are optional. Raises
        ConfigError for unknown or missing functions.
        """
        if wrong := functions.keys() - {"begin_world", "begin_tick"} ^ {"brightness_at", "score"}:
            raise ConfigError(
                f"functions of {cls.__name__}: {', '.join(sorted(wrong))} unknown or missing;"
                " must be brightness_at and score, and optionally begin_world and begin_tick"
            )
        cls.robot_kind, cls.world_kind, cls.task_functions = robot, world, functions

    def __init__(
        self, scenarios: Sequence[EpuckScenario], seeds: Sequence[int], physics: str = "rigid"
    ) -> None:
        """Make one world for each scenario, and place its robots by its seed; none has sensed yet.

        All scenarios must have the same number of robots. Without seeds, robots are not placed.
        """
        super().__init__(scenarios)
        shape = (self.n_worlds, self.n_robots)
        n_slots = max(scenario.radio.slots for scenario in scenarios)
        self.robots = np.zeros(shape, self.robot_kind.dtype(slots=n_slots))
        """Record of each robot, shape (worlds, robots); writing to it changes the worlds."""
        self.faults = np.zeros(shape, Fault.dtype())
        """Present and future faults of each robot."""
        self.worlds = self.world_kind.array((self.n_worlds,))
        """Clock and scenario parameters of each world."""
        self.near: Int32[Array, "worlds robots columns"] = np.zeros((*shape, FIRST), np.int32)
        """Neighbour lists, as written by `find_neighbours`."""
        self.obstacles: Float64[Array, "worlds obstacles 5"] = np.zeros((self.n_worlds, 0, 5))
        """Capsules of each world; the first `n_obstacles` are valid, the rest zeros."""
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
        """Write the task's parameters of a scenario to the records of its worlds."""

    def write_parameters(self, first: int, last: int) -> None:
        """Write the scenario parameters of these worlds, and make room for neighbours and cells."""
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
        """Place the robots, and start their random streams from the seeds of the worlds."""
        self.starts[1][first:last] = seeds
        place_all(self.arrays[:7], self.starts, self.errors, first, last)
        for w in range(first, last):
            self._physics.reset(w, self.scenarios[w])

    @property
    def arrays(self) -> tuple[Array, ...]:
        """Arrays that the templates of a tick take."""
        own = self.robots, self.worlds, self.near, self._cells, self.obstacles
        return (*own, self.rewards, self.faults, *self._physics.arrays)

    @property
    def functions(self) -> Mapping[str, Kernel]:
        """Functions bound to the free names of `run_ticks`."""
        return {**TICK, **self.task_functions, "move_world": self._physics.move_world}

    def move(self, first: int, last: int) -> None:
        """Move the robots of the worlds first .. last - 1 if the engine is not compiled."""
        if not self.is_compiled:
            engine: Any = self._physics
            engine.move(self.robots, self.worlds, self.near, self.obstacles, first, last)

    def snapshot(self) -> dict[str, Any]:
        """Return the full state: arrays, scenarios and the state of the engine."""
        return super().snapshot() | {"_physics": self._physics.snapshot()}

    def restore(self, snapshot: Mapping[str, Any]) -> None:
        """Continue from a snapshot."""
        super().restore({name: each for name, each in snapshot.items() if name != "_physics"})
        self._physics.restore(snapshot["_physics"], self.scenarios)


def _widened(table: Array, width: int, fill: int, axis: int = -1) -> Array:
    """Return a table at least `width` wide along an axis; the same table if it is wide enough."""
    shape = list(table.shape)
    shape[axis] = more = max(0, width - table.shape[axis])
    added = np.full(shape, fill, table.dtype)
    return np.concatenate([table, added], axis=axis) if more else table


def reach_of(scenario: EpuckScenario) -> float:
    """Return the distance within which robots are listed as neighbours, centre to centre [m].

    The list is made before contacts are resolved, and an engine uses it in the next tick. Until
    then two robots approach each other by the path that each drives and by the path that others
    push each of them, which is hardly longer than these drive.
    """
    robot = scenario.robot
    touching, way = 2.0 * robot.radius, robot.cruise_speed * scenario.tick
    sensed = max(touching + SENSING_RANGE, scenario.radio.max_range) + SLACK
    return max(sensed, touching + 4.0 * way)


def max_neighbours(scenario: EpuckScenario) -> int:
    """Return the room for neighbours: twice the number of discs that fit without overlapping."""
    discs = ((reach_of(scenario) + scenario.robot.radius) / scenario.robot.radius) ** 2
    return min(max(1, scenario.task.n_robots - 1), 2 * math.ceil(discs) + 8)


def write_numbers(scenario: EpuckScenario, out_worlds: Array | np.void) -> None:
    """Write the parameters of a scenario to the records of its worlds, as kernels read them."""
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
