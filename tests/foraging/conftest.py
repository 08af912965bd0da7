"""Fixtures of the foraging world: robots put at given places, running swarms, and all they hold."""

import numpy as np
import pytest

import baselines.controllers  # noqa: F401
import swarm_forage_env.foraging.named
import swarm_forage_env.foraging.task  # noqa: F401 all three enter their parts
from swarm_forage_env.compiler import bind, entry_point
from swarm_forage_env.epuck.contacts import resolve_contacts
from swarm_forage_env.epuck.fault_record import Fault
from swarm_forage_env.epuck.placing import SOURCES
from swarm_forage_env.epuck.surroundings import FIRST, find_neighbours, find_neighbours_of
from swarm_forage_env.epuck.tick import hear
from swarm_forage_env.epuck.world import TICK, write_numbers
from swarm_forage_env.equations.neighbours import EMPTY, cells_of
from swarm_forage_env.foraging.records import RobotState, WorldState
from swarm_forage_env.foraging.world import ForagingWorld
from swarm_forage_env.loop import Loop
from swarm_forage_env.random_streams import streams
from swarm_forage_env.record import rows
from swarm_forage_env.registry import CONTROLLERS
from swarm_forage_env.scenarios import find_scenario
from swarm_forage_env.ticks import START, only, run_ticks
from tests.worlds import check_same_world, everything


@entry_point
def look_around(robots, worlds, near, cells):
    """List the neighbours in every world; the most that any robot has."""
    most = 0
    for w in range(worlds.shape[0]):
        most = max(most, find_neighbours(robots[w], near[w], cells[w], worlds[w]))
    return most


@entry_point
def look_around_each(robots, worlds, near):
    """The same, every robot by itself, as on a GPU."""
    most = 0
    for w in range(worlds.shape[0]):
        for i in range(robots.shape[1]):
            most = max(most, find_neighbours_of(robots[w], i, near[w], worlds[w]))
    return most


@entry_point
def settle(robots, worlds, near, cells, obstacles):
    """Resolve the contacts of every world; in how many worlds that succeeded."""
    settled = 0
    for w in range(worlds.shape[0]):
        find_neighbours(robots[w], near[w], cells[w], worlds[w])
        settled += resolve_contacts(robots[w], near[w], worlds[w], obstacles[w])
    return settled


@entry_point
def deliver(robots, worlds, near, cells, obstacles):
    """Deliver the messages in every world."""
    for w in range(worlds.shape[0]):
        find_neighbours(robots[w], near[w], cells[w], worlds[w])
        for i in range(robots.shape[1]):
            hear(robots[w], i, near[w], worlds[w], obstacles[w])


class Block:
    """Worlds of robots at the same given places, without an engine and a controller."""

    def __init__(self, places, n_worlds=1, **numbers):
        """Places are (x, y, heading); numbers of es1 are changed by name, `reach` directly.

        `obstacles` are capsules, the same in every world.
        """
        reach, obstacles = numbers.pop("reach", None), numbers.pop("obstacles", ())
        scenario, n_robots = find_scenario("es1", numbers), len(places)
        self.worlds = WorldState.array((n_worlds,))
        write_numbers(scenario, self.worlds[0])
        ForagingWorld.write_task(scenario, self.worlds[:1])
        self.worlds[:] = self.worlds[0]
        if reach is not None:
            self.worlds["reach"] = reach
        standing = np.array(obstacles, np.float64).reshape(-1, 5)
        self.worlds["n_obstacles"] = len(standing)
        self.obstacles = np.repeat(standing[None], n_worlds, axis=0)
        shape = n_worlds, n_robots
        self.robots = RobotState.array(shape, slots=scenario.radio.slots)
        self.robots["pose"] = places
        self.robots["command"]["is_speaking"] = True
        for column, source in enumerate(SOURCES):
            words = streams(range(n_worlds), n_robots, source)
            self.robots["streams"][:, :, column] = words.reshape(shape)
        self.near = np.full((*shape, FIRST + max(1, n_robots - 1)), -7, np.int32)
        length, width = self.worlds["arena"][0]
        n_cells = cells_of(length, self.reach) * cells_of(width, self.reach)
        self.cells = np.full((n_worlds, n_cells), EMPTY, np.int32)

    @property
    def reach(self):
        return float(self.worlds["reach"][0])

    @property
    def state(self):
        """The robots, a row for each of every world."""
        return rows(self.robots)

    @property
    def tables(self):
        return self.robots, self.worlds, self.near, self.cells, self.obstacles

    def look_around(self):
        """The most neighbours that any robot has."""
        return look_around(self.robots, self.worlds, self.near, self.cells)

    def look_around_each(self):
        """The same, found by every robot by itself."""
        return look_around_each(self.robots, self.worlds, self.near)

    def settle(self):
        """Resolve contacts; whether that succeeded in all worlds."""
        n_settled = settle(*self.tables)
        return n_settled == len(self.worlds)

    def sense(self):
        """What the robots' own sensors read."""
        n_worlds, rewards = len(self.worlds), np.zeros(self.robots.shape)
        modes, errors = np.full(n_worlds, START, np.int8), np.zeros(n_worlds + 1, np.int64)
        tick = bind(run_ticks, {**only("tick"), **TICK, **ForagingWorld.task_functions})
        faults = Fault.array(self.robots.shape)
        tick((*self.tables, rewards, faults), (), modes, errors, 0, n_worlds, 1)
        return self.state.readings

    def receive(self):
        """What the robots hear, and which slots hold a message."""
        deliver(*self.tables)
        heard = self.state.heard
        return heard, np.arange(heard.sender.shape[1]) < heard.n[:, None]


@pytest.fixture(scope="session")
def block():
    return Block


CROWD = {"n_robots": 15, "arena.length": 0.8, "arena.width": 0.8, "area_distance": 0.59,
         "area_radius": 0.05}  # fmt: skip
"""So narrow an es1 that bodies touch each other and the walls in every tick."""


@pytest.fixture(scope="session")
def running():
    """A block of worlds under a controller."""

    def start(scenario, seeds, physics="rigid", controller="ssgiff", threads=1, **overrides):
        scenario = find_scenario(scenario, overrides)
        return Loop(scenario, CONTROLLERS[controller], seeds, physics, threads)

    return start


@pytest.fixture(scope="session")
def go():
    """One tick of a world under the same command to all: wheels [m/s], and whether they speak."""

    def tick(world, wheels=0.0, speaking=False):
        state = world.state
        speed = np.asarray(wheels) / world.scenario.robot.cruise_speed
        state.command.wheels[:] = speed
        state.command.is_speaking[:] = speaking
        world.tick(0, world.n_worlds)
        return state

    return tick


@pytest.fixture(scope="session")
def bits():
    """All that is true, sensed, believed and drawn in a running block, by name, as bytes."""
    return lambda loop: {name: each.tobytes() for name, each in everything(loop).items()}


@pytest.fixture(scope="session")
def same():
    """Assert that worlds of two running blocks are in the same state, bit for bit."""
    return check_same_world
