"""The worlds of a loop on a GPU: a CPU makes them, the GPU runs them and starts them anew.

    decide -> tick -> observe -> [the cut] -> decide ...

Each is one kernel over all worlds. The records stay in the memory of the GPU; what is asked for is
copied back. A kernel cannot raise: what goes wrong is noted, and raised by `check`.
"""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from swarm_forage_env.arrays import Array
from swarm_forage_env.compiler import bind_grid
from swarm_forage_env.device_memory import DeviceMemory, Grid
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.interface import (
    NO_ROOM,
    NOT_FINITE,
    REFUSED,
    TOO_MANY_NEAR,
    GridLayers,
    GridTemplates,
)
from swarm_forage_env.loop import Loop
from swarm_forage_env.observed_fields import FieldLayout, spans_of
from swarm_forage_env.random_streams import checked_seed
from swarm_forage_env.task import World, checked_worlds, consecutive

MOST_THREADS = 128
"""Threads of a block, at most: so many that each may have all registers that one can have."""


class DeviceLoop:
    """A block of worlds and the controller of all their robots, on a GPU.

    The loop that it is made from stays on the CPU: what it holds of robots is as old as the last
    `download`. ConfigError for what does not run on a GPU, with the reason.
    """

    def __init__(self, loop: Loop) -> None:
        """Bring the worlds of a loop to the GPU, as they stand."""
        self._layers, self._templates = _layers_of(loop)
        self.loop, self.memory = loop, DeviceMemory()
        functions, templates = self._layers.functions, self._templates
        self.driving = driving = self._layers.templates or templates.layers
        """The templates of what drives the robots."""
        self.potential = templates.potential
        """The function of the potential of one robot."""
        self._decide, self._tick, self._observe = (
            bind_grid(template, functions)
            for template in (driving.decide, templates.tick, driving.observe)
        )
        shape = loop.world.robots.shape
        self.grid = grid_of(*shape)
        """Blocks, and threads of a block: robots by worlds."""
        self.trouble = self.memory.to_device(np.zeros(4, np.int64))
        self.earned = self.memory.to_device(np.zeros(shape))
        """What each robot earned since somebody set it to 0."""
        self._crowded = self.memory.to_device(np.zeros(shape[0], np.int8))
        self._everywhere = self.memory.to_device(np.ones(shape[0], np.int8))
        self._upload_all()
        self._prepare_resets()

    @property
    def world(self) -> World:
        """The worlds on the CPU: their scenarios hold, their records are old."""
        return self.loop.world

    @property
    def launch(self) -> tuple[Any, ...]:
        """What a kernel over all worlds is launched on: the grid, and the stream of the memory."""
        return self.memory.launch(self.grid)

    @property
    def stages(self) -> dict[str, Callable[[], None]]:
        """The kernels of a tick of every world, in their order."""
        return {name: partial(run, self._everywhere) for name, run in self._stages.items()}

    def step(self, runs: Any = None) -> None:  # noqa: ANN401 an array of the GPU
        """One tick of every world, or of those that `runs`, of which nothing is copied back.

        `runs` is a number for each world, int8: 0 for one that stands still.
        """
        for run in self._stages.values():
            run(self._everywhere if runs is None else runs)

    @property
    def traffic(self) -> dict[str, int]:
        """Bytes of the records of each stage: read once, and once more for those that it writes."""
        at = self.arrays
        return {
            stage: sum(at[name].nbytes for name in (*HANDED[stage], *WRITTEN[stage]))
            for stage in self.stages
        }

    def reset(
        self,
        seeds: Sequence[int],
        worlds: Sequence[int] | None = None,
        scenarios: Sequence[Any] | None = None,
    ) -> None:
        """Start worlds anew, each from its seed, as `Loop.reset`; nothing is copied back.

        Numbers of other scenarios are written by the CPU. It also starts worlds anew of which the
        task says so. Where robots find no room, `check` raises it.
        """
        which = checked_worlds(worlds, self.world.n_worlds)
        now = [self.world.scenarios[w] for w in which] if scenarios is None else scenarios
        different = {id(scenario): scenario for scenario in now}.values()
        if not all(map(self._templates.restarts, different)):
            self.loop.reset(seeds, which, scenarios)
            self.upload(which)
            return
        if scenarios is not None:
            self.loop.renumber(scenarios, which)
            self.upload(which, NUMBERS)
        own, is_new = np.zeros(len(self.world.scenarios), np.uint64), self._mask(which)
        own[which] = [checked_seed(seed) for seed in seeds]
        self._restart(self.memory.to_device(own), self.memory.to_device(is_new))

    def fields(self, layout: FieldLayout) -> tuple[Any, Any, int, Any]:
        """The words of robots and minds, how many robots a world has, and the spans of a layout."""
        at, own = self.arrays, self._layers.minds.dtype
        is_estimator = self._layers.templates is None
        minds = np.dtype([("estimator", own)]) if is_estimator else own
        spans = spans_of(layout, {"robots": self.world.robots.dtype, "minds": minds})
        words = (at[name].view(np.float32) for name in ("robots", "minds"))
        return (*words, self.world.n_robots, self.memory.to_device(spans))

    def upload(self, which: Sequence[int], names: Sequence[str] | None = None) -> None:
        """Bring these worlds to the GPU as they stand on the CPU, or arrays of these names."""
        host = self._host()
        if any(self.arrays[name].shape != own.shape for name, own in host.items()):
            raise ConfigError(
                "device='cuda': the scenario of an episode has more obstacles or wider neighbours"
                " than those before; begin with the largest, or take device='cpu'"
            )
        for first, last in consecutive(which):
            for name, own in host.items():
                if own.size and (names is None or name in names):
                    self.memory.write(self.arrays[name][first:last], own[first:last])

    def download(self) -> Loop:
        """The loop on the CPU, with its robots, worlds and minds as they stand on the GPU."""
        host = self._host()
        for name in CHANGED:
            host[name][...] = self.memory.read(self.arrays[name])
        return self.loop

    def check(self) -> None:
        """Raise what went wrong since the last time: waits for the GPU.

        ConfigError for a command, a weight or an action that cannot be used, RuntimeError where
        there was no room for all neighbours.
        """
        trouble = self.memory.read(self.trouble)
        if not trouble.any():
            return
        self.memory.write(self.trouble, np.zeros_like(trouble))
        if trouble[REFUSED]:
            raise ConfigError(
                f"actions of world {trouble[REFUSED] - 1}: must be finite and within the action"
                " space; clip them first, as torch.clamp does"
            )
        if trouble[NOT_FINITE]:
            raise ConfigError(
                f"world {trouble[NOT_FINITE] - 1}: a command or a weight is not finite; a number of"
                " a layer or of a policy is too large"
            )
        if trouble[NO_ROOM]:
            raise ConfigError(
                f"world {trouble[NO_ROOM] - 1}: the robots found no place in the start circle;"
                " enlarge task.start_radius"
            )
        raise RuntimeError(
            f"world {trouble[TOO_MANY_NEAR] - 1}: a robot has more neighbours than discs of its"
            " radius can be without overlapping: contacts were not resolved"
        )

    def _mask(self, which: Sequence[int]) -> Array:
        """These worlds, as a number for each."""
        mask = np.zeros(self.world.n_worlds, np.int8)
        mask[which] = True
        return mask

    def _prepare_resets(self) -> None:
        """Bring to the GPU what worlds start from, and compile what starts them."""
        layers, templates, shape = self._layers, self._templates, self.world.robots.shape
        memory = self.memory
        self._place, self._forget, self._sense_first = (
            bind_grid(template, layers.functions)
            for template in (templates.place, self.driving.forget, templates.sense_first)
        )
        robot = np.zeros(1, self.world.robots.dtype)
        templates.robot.restart(robot)
        self._first_robot = memory.to_device(robot)
        self._firsts = memory.to_device(layers.first_mind), memory.to_device(layers.first_memory)
        self._places = memory.empty(shape, np.uint64), memory.empty((*shape, 3), np.float64)

    def _restart(self, seeds: Any, is_new: Any) -> None:  # noqa: ANN401 arrays of the GPU
        at, on, trouble = self.arrays, self.launch, self.trouble
        robots, worlds, firsts = at["robots"], at["worlds"], self._firsts
        self._place[on](robots, worlds, self._first_robot, seeds, is_new, *self._places, trouble)
        self._forget[on](at["minds"], at["memories"], *firsts, seeds, is_new, self._layers.noise)
        self._sense_first[on](robots, worlds, at["near"], at["obstacles"], is_new, trouble)
        self._observe_in(is_new)

    @property
    def _stages(self) -> dict[str, Callable[[Any], None]]:
        return {"decide": self._decide_in, "tick": self._tick_in, "observe": self._observe_in}

    def _decide_in(self, runs: Any) -> None:  # noqa: ANN401 an array of the GPU
        self._decide[self.launch](*self._handed("decide"), self.trouble, runs)

    def _tick_in(self, runs: Any) -> None:  # noqa: ANN401 as above
        handed = self._handed("tick")
        self._tick[self.launch](*handed, self._crowded, self.earned, self.trouble, runs)

    def _observe_in(self, runs: Any) -> None:  # noqa: ANN401 as above
        self._observe[self.launch](*self._handed("observe"), runs)

    def _handed(self, stage: str) -> list[Any]:
        return [self.arrays[name] for name in HANDED[stage]]

    def _upload_all(self) -> None:
        self.arrays = {name: self.memory.to_device(own) for name, own in self._host().items()}

    def _host(self) -> dict[str, Array]:
        """The arrays on the CPU, as views."""
        world, layers = self.loop.world, self._layers
        tables = {name: getattr(world, name) for name in ("robots", "worlds", "near", "obstacles")}
        names = "minds", "memories", "shared", "told", "settings"
        return tables | {name: getattr(layers, name) for name in names}


HANDED = {
    "decide": ("robots", "minds", "memories", "shared", "settings"),
    "tick": ("robots", "worlds", "near", "obstacles"),
    "observe": ("robots", "minds", "shared", "told"),
}
"""Arrays that the kernel of each stage is handed first."""

WRITTEN = {
    "decide": ("robots", "minds", "memories"),
    "tick": ("robots", "worlds", "near"),
    "observe": ("robots", "minds"),
}
"""Those of them that it writes."""

CHANGED = "robots", "worlds", "minds", "memories"
"""Arrays of which a tick goes on: what it reads and what ticks before it have written."""

NUMBERS = "worlds", "obstacles", "told", "settings"
"""Arrays that hold the numbers of a scenario."""


def grid_of(n_worlds: int, n_robots: int) -> Grid:
    """Blocks, and threads of a block: robots by worlds.

    >>> grid_of(1000, 10)
    (84, (10, 12))
    >>> grid_of(3, 1000)
    (3, (128, 1))
    """
    robots = min(n_robots, MOST_THREADS)
    worlds = min(n_worlds, MOST_THREADS // robots)
    return -(-n_worlds // worlds), (robots, worlds)


def _layers_of(loop: Loop) -> tuple[GridLayers, GridTemplates]:
    """How a GPU runs a loop's controller and worlds; ConfigError for what a CPU runs only."""
    if loop.task.grid is None:
        raise ConfigError(f"device='cuda': the task {loop.task.name} runs on a CPU only")
    if loop.physics != "kinematic":
        raise ConfigError(
            f"device='cuda': the engine {loop.physics} runs on a CPU only, as it asks a library;"
            " take physics='kinematic'"
        )
    ask = getattr(loop.controller, "grid_layers", None)
    if ask is None:
        raise ConfigError(
            "device='cuda': robots of several teams run on a CPU only; take one controller of"
            " three layers, as ssgikf, or a policy that is everything"
        )
    return ask(), loop.task.grid
