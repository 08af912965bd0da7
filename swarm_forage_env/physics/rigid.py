"""The engine `rigid`: pymunk discs that push, slide along and turn each other in contacts."""

from collections.abc import Sequence
from typing import Any

import pymunk
from pymunk._chipmunk import ffi, lib
from pymunk.batch import BodyFields

from swarm_forage_env.arrays import Array
from swarm_forage_env.epuck.obstacles import capsules_of
from swarm_forage_env.epuck.scenario import EpuckScenario
from swarm_forage_env.interface import Kernel
from swarm_forage_env.physics.base import ENGINES, Physics
from swarm_forage_env.physics.contact_memory import ContactMemory, recall, remembered
from swarm_forage_env.physics.pymunk_buffers import SpaceMemory, address_of, move_world

MASS = 0.15
"""Mass of an e-puck [kg]. GCtronic e-puck specification."""
FRICTION = 0.2
"""Friction coefficient of bodies, walls and obstacles (chosen)."""

TO_READ = BodyFields.POSITION | BodyFields.ANGLE
TO_WRITE = TO_READ | BodyFields.VELOCITY | BodyFields.ANGULAR_VELOCITY


@ENGINES.register("rigid")
class Rigid(Physics):
    """Robots in contact push, slide and turn each other; one pymunk space per world.

    If no robot of a world can reach another, a wall or an obstacle in a tick, the space is not
    stepped: the tick moves each robot along its chord, as the space would.
    """

    def __init__(self, scenarios: Sequence[EpuckScenario]) -> None:
        n_bodies = scenarios[0].task.n_robots + 1  # the last one is the static body of the walls
        self._memory = SpaceMemory.array((len(scenarios),), bodies=n_bodies, rows=2 * n_bodies + 8)
        self.arrays = (self._memory,)
        self._arguments = [_connected(self._memory[w : w + 1]) for w in range(len(scenarios))]
        self._spaces: dict[int, pymunk.Space] = {}
        for w, scenario in enumerate(scenarios):
            self.reset(w, scenario)

    @property
    def move_world(self) -> Kernel:
        """Kernel that moves the robots of a world where bodies may touch."""
        return move_world

    def reset(self, world: int, scenario: EpuckScenario) -> None:
        """Replace the space of a world: the old one keeps the impulses of its last contacts."""
        self._spaces[world] = space_of(scenario)
        self._memory["at"][world] = address_of(self._spaces[world]._space)

    def snapshot(self) -> list[ContactMemory]:
        """Return the contact state of the space of each world."""
        return [remembered(space) for space in self._spaces.values()]

    def restore(self, kept: Sequence[ContactMemory], scenarios: Sequence[EpuckScenario]) -> None:
        """Replace the spaces by new ones with these contact states."""
        for world, (memory, scenario) in enumerate(zip(kept, scenarios, strict=True)):
            self.reset(world, scenario)
            recall(self._spaces[world], memory)


def space_of(scenario: EpuckScenario) -> pymunk.Space:
    """Return a space with the robots of a world, in order, its four walls and its obstacles."""
    space = pymunk.Space()
    space.collision_slop = 1e-4
    radius = scenario.robot.radius
    for i in range(scenario.task.n_robots):
        body = pymunk.Body(MASS, pymunk.moment_for_circle(MASS, 0.0, radius))
        body.position = 4.0 * radius * i, 0.0  # at one point all would pair with all
        shape = pymunk.Circle(body, radius)
        shape.friction = FRICTION
        space.add(body, shape)
    x, y = 0.5 * scenario.arena.length, 0.5 * scenario.arena.width
    corners = [(-x, -y), (x, -y), (x, y), (-x, y)]
    outer, inner = capsules_of((), corners), capsules_of(scenario.obstacles, scenario.arena.corners)
    for ax, ay, bx, by, thick in (*outer.tolist(), *inner.tolist()):
        wall = pymunk.Segment(space.static_body, (ax, ay), (bx, by), thick)
        wall.friction = FRICTION
        space.add(wall)
    return space


def _connected(memory: Array) -> list[object]:
    memory["writer"] = address_of(ffi.addressof(lib, "pmSpaceBodySetIteratorFuncBatched"))
    memory["reader"] = address_of(ffi.addressof(lib, "pmSpaceBodyGetIteratorFuncBatched"))
    to_write = _argument(TO_WRITE, memory["writing"], memory["written"])
    to_read = _argument(TO_READ, memory["reading"], memory["read"])
    memory["to_write"], memory["to_read"] = address_of(to_write), address_of(to_read)
    return [to_write, to_read]


def _argument(fields: BodyFields, floats: Array, numbers: Array) -> Any:  # noqa: ANN401 pymunk's
    argument = ffi.new("pmBatchedData *")
    argument.fields = fields.value
    argument.floatArray = ffi.cast("pmFloatArray *", floats.ctypes.data)
    argument.floatArray.arr = ffi.cast("cpFloat *", numbers.ctypes.data)
    argument.floatArray.max = numbers.size
    return argument
