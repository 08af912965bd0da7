"""The engine `rigid`: discs that push, slide and turn each other in a contact, by pymunk."""

import threading
from collections.abc import Sequence

import numpy as np
import pymunk
from pymunk.batch import BodyFields, Buffer, get_space_bodies, set_space_bodies

from swarm_forage_env.arrays import Array, Bool, Float64
from swarm_forage_env.foraging.obstacles import capsules_of
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.physics.base import ENGINES
from swarm_forage_env.physics.contact_memory import ContactMemory, recall, remembered
from swarm_forage_env.physics.pymunk_buffers import read_bodies, write_bodies

SUBSTEPS = 2
MASS = 0.15
"""Mass of an e-puck [kg]. GCtronic e-puck specification."""
FRICTION = 0.2
"""Between bodies, and between a body and a wall (chosen)."""

_WRITTEN = (
    BodyFields.POSITION | BodyFields.ANGLE | BodyFields.VELOCITY | BodyFields.ANGULAR_VELOCITY
)
_READ = BodyFields.POSITION | BodyFields.ANGLE


@ENGINES.register("rigid")
class Rigid:
    """Bodies push, slide and turn each other where they touch, by pymunk, one space a world.

    In a tick in which no body of a world can reach another, a wall or an obstacle, its space would
    only carry each robot along its chord; that is left to the kernel `tick`.
    """

    def __init__(self, scenarios: Sequence[Scenario]) -> None:
        """Spaces with the robots and walls of these scenarios."""
        n_worlds = len(scenarios)
        self._touching: Bool[Array, " worlds"] = np.zeros(n_worlds, np.bool_)
        n_bodies = scenarios[0].task.n_robots + 1  # the walls' static body comes last
        self._written: Float64[Array, "worlds bodies 6"] = np.zeros((n_worlds, n_bodies, 6))
        # pymunk reallocates a buffer it finds full, which must not happen to NumPy's memory
        self._read: Float64[Array, "worlds numbers"] = np.zeros((n_worlds, 6 * n_bodies + 16))
        self._one_at_a_time = threading.Lock()
        """Held by the thread that is in pymunk, which lets go of Python's own at every call."""
        self._scenarios = list(scenarios)
        self._spaces = [_space(scenario) for scenario in scenarios]
        self._buffers = [
            (_buffer(self._written[w]), _buffer(self._read[w])) for w in range(n_worlds)
        ]

    def move(
        self, robots: Array, worlds: Array, near: Array, obstacles: Array, first: int, last: int
    ) -> None:
        """Move the worlds in which bodies may touch."""
        write_bodies(robots, worlds, near, obstacles, first, last, self._written, self._touching)
        with self._one_at_a_time:
            for w in np.flatnonzero(self._touching[first:last]) + first:
                space, (written, read) = self._spaces[w], self._buffers[w]
                set_space_bodies(space, _WRITTEN, written)
                for _ in range(SUBSTEPS):
                    space.step(self._scenarios[w].tick / SUBSTEPS)
                read.clear()
                get_space_bodies(space, _READ, read)
        read_bodies(self._read, self._touching, first, last, robots, worlds)

    def reset(self, world: int, scenario: Scenario) -> None:
        """Start from a new space: the old one keeps the impulses of its last contacts."""
        self._scenarios[world] = scenario
        self._spaces[world] = _space(scenario)

    def snapshot(self) -> list[ContactMemory]:
        """What the space of each world remembers."""
        return [remembered(space) for space in self._spaces]

    def restore(self, kept: Sequence[ContactMemory], scenarios: Sequence[Scenario]) -> None:
        """Go on in new spaces that remember the same."""
        for world, (memory, scenario) in enumerate(zip(kept, scenarios, strict=True)):
            self.reset(world, scenario)
            recall(self._spaces[world], memory)

    def __getstate__(self) -> tuple[list[Scenario], list[ContactMemory]]:
        """Scenarios and memories: spaces, buffers and lock are made anew from them."""
        return self._scenarios, self.snapshot()

    def __setstate__(self, state: tuple[list[Scenario], list[ContactMemory]]) -> None:
        """The engine as it was."""
        scenarios, kept = state
        Rigid.__init__(self, scenarios)
        self.restore(kept, scenarios)


def _space(scenario: Scenario) -> pymunk.Space:
    """A space with the robots of one world, in order, its four walls and its obstacles."""
    space = pymunk.Space()
    space.collision_slop = 1e-4
    radius = scenario.robot.radius
    for i in range(scenario.task.n_robots):
        body = pymunk.Body(MASS, pymunk.moment_for_circle(MASS, 0.0, radius))
        body.position = 4.0 * radius * i, 0.0  # in one place, each would pair with each
        shape = pymunk.Circle(body, radius)
        shape.friction = FRICTION
        space.add(body, shape)
    x, y = 0.5 * scenario.arena.length, 0.5 * scenario.arena.width
    corners = [(-x, -y), (x, -y), (x, y), (-x, y)]
    for a, b in zip(corners, corners[1:] + corners[:1], strict=True):
        wall = pymunk.Segment(space.static_body, a, b, 0.0)
        wall.friction = FRICTION
        space.add(wall)
    for ax, ay, bx, by, thick in capsules_of(scenario.obstacles, scenario.arena.corners).tolist():
        obstacle = pymunk.Segment(space.static_body, (ax, ay), (bx, by), thick)
        obstacle.friction = FRICTION
        space.add(obstacle)
    return space


def _buffer(memory: Array) -> Buffer:
    """A buffer of pymunk that reads and writes NumPy's memory."""
    buffer = Buffer()
    buffer.set_float_buf(memory)
    return buffer
