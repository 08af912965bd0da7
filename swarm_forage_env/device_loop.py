"""A loop whose worlds run on a GPU, where they are also reset.

Ticks have the same source as on a CPU, `run_ticks`, in one launch. The records stay in the memory
of the GPU; arrays are copied back when they are read. A kernel cannot raise: it writes error codes,
and `check` raises them.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property, partial
from typing import Any

import numpy as np

from swarm_forage_env.arrays import Array
from swarm_forage_env.compiler import GridKernel, bind_grid
from swarm_forage_env.device_memory import DeviceMemory, Grid
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.interface import CompiledLayers, Kernel
from swarm_forage_env.loop import Loop
from swarm_forage_env.observed_fields import FieldLayout, spans_of
from swarm_forage_env.task import World, consecutive
from swarm_forage_env.ticks import START, begin_worlds, only, run_ticks
from swarm_forage_env.worlds_on_cpu import PlacedArray, checked_device

MAX_THREADS = 128
"""Maximum number of threads per block; with more, a thread cannot use the most registers."""

ENOUGH_BLOCKS = 160
"""Number of blocks for few worlds: about one for each multiprocessor of a large GPU."""


class DeviceLoop:
    """A block of worlds and the controller of all their robots, on a GPU.

    The loop that it is created from stays on the CPU; its records are those of the last
    `download`. ConfigError, with the reason, for what does not run on a GPU.
    """

    def __init__(self, loop: Loop) -> None:
        """Copy the worlds of a loop to the GPU; of a blank loop, only the first is transferred."""
        self.layers, on_gpu = _layers_of(loop)
        self.loop, self.memory = loop, DeviceMemory()
        self.functions = {**loop.world.functions, **self.layers.functions, **on_gpu}
        """Functions bound to the free names of `run_ticks` and `begin_worlds`."""
        self._run = bind_grid(run_ticks, self.functions)
        self._begin = bind_grid(begin_worlds, self.functions)
        shape = loop.world.robots.shape
        self.grid = grid_of(*shape)
        """Number of blocks, and threads of a block (robots, worlds)."""
        self._modes = self.memory.to_device(loop.world.modes)
        put = self.memory.repeated if loop.is_blank else self.memory.to_device
        self.arrays = {name: put(array) for name, array in self._host().items()}
        self.errors = self.memory.to_device(loop.world.errors)
        """Error code of each world since the last call of `check`."""
        world, layers = (tuple(self.arrays[name] for name in names) for names in (WORLD, LAYERS))
        self.tick_arrays = world, layers, self.errors
        """Arguments of the templates of ticks: arrays of worlds and layers, and error codes."""
        first_robot, *places = map(self.memory.repeated, loop.world.starts)
        firsts = map(self.memory.to_device, self.layers.firsts)
        self.starts: tuple[Any, ...] = first_robot, *firsts, *places
        """Arrays from which worlds start: `World.starts`, with initial records of the layers."""

    @property
    def world(self) -> World:
        """Worlds on the CPU: their scenarios are current, their records are not."""
        return self.loop.world

    @property
    def launch(self) -> tuple[Any, ...]:
        """Launch configuration of a kernel over all worlds: the grid, and the memory's stream."""
        return self.memory.launch(self.grid)

    @property
    def estimators(self) -> PlacedArray | None:
        """State of the estimators, shape (worlds, robots); None if no robot has one."""
        return self.arrays["minds"] if self.layers.has_beliefs else None

    def kernel(self, template: Kernel, functions: Mapping[str, Kernel]) -> Callable[..., None]:
        """Return a template over worlds as one launch; the last argument is added here."""
        compiled, n_worlds = bind_grid(template, functions), self.world.n_worlds

        def run(*arguments: object) -> None:
            compiled[self.launch](*arguments, (0, n_worlds))

        return run

    def run(self, n_ticks: int, modes: PlacedArray | None = None) -> None:
        """Run ticks of all worlds in one launch; `modes`, int8, are SKIP, RUN (default), START."""
        self._launch(self._run, n_ticks, self._modes if modes is None else modes)

    def step(self, modes: PlacedArray | None = None) -> None:
        """Run one tick of every world, or of those that `modes` selects."""
        self.run(1, modes)

    @cached_property
    def stages(self) -> dict[str, Callable[[], None]]:
        """Stages of a tick of every world, each as a separate kernel, for timing."""
        kernels = {name: bind_grid(run_ticks, {**self.functions, **only(name)}) for name in INPUTS}
        return {name: partial(self._launch, each, 1, self._modes) for name, each in kernels.items()}

    def _launch(self, kernel: GridKernel, n_ticks: int, modes: PlacedArray) -> None:
        (world, layers, errors), n_worlds = self.tick_arrays, self.world.n_worlds
        kernel[self.launch](world, layers, modes, errors, 0, n_worlds, n_ticks)

    @property
    def traffic(self) -> dict[str, int]:
        """Bytes moved by each stage: arrays that it reads, plus arrays that it writes."""
        at = self.arrays
        return {
            stage: sum(at[name].nbytes for name in (*INPUTS[stage], *OUTPUTS[stage]))
            for stage in self.stages
        }

    def reset(
        self,
        seeds: Sequence[int],
        worlds: Sequence[int] | None = None,
        scenarios: Sequence[Any] | None = None,
    ) -> None:
        """Reset worlds, each from its seed, as `Loop.reset` does; nothing is copied back.

        The CPU writes the parameters of other scenarios. If robots find no room, `check` raises.
        """
        seed_of = self.world.seed_of(seeds, worlds)
        indices = [*seed_of]
        if scenarios is not None:
            self.loop.replace_scenarios(scenarios, indices)
            self.upload(indices, PARAMETER_ARRAYS)
        n_worlds = self.world.n_worlds
        all_seeds, modes = np.zeros(n_worlds, np.uint64), np.zeros(n_worlds, np.int8)
        all_seeds[indices], modes[indices] = [*seed_of.values()], START
        self.memory.write(self.starts[3], all_seeds)
        placed, (world, layers, errors) = self.memory.to_device(modes), self.tick_arrays
        self._begin[self.launch](world, layers, self.starts, self.layers.noise, placed, errors)
        self.run(1, placed)

    def fields(self, layout: FieldLayout) -> tuple[Any, Any, Any, Any, int]:
        """Return the location of the fields of a layout, for `read_fields` and `write_fields`."""
        at, kind = self.arrays, self.layers.arrays[0].dtype
        minds = np.dtype([("estimator", kind)]) if self.layers.has_beliefs else kind
        spans = spans_of(layout, {"robots": self.world.robots.dtype, "minds": minds})
        robots, words = (at[name].view(np.float32) for name in ("robots", "minds"))
        return robots, words, robots, self.memory.to_device(spans), self.world.n_robots

    def upload(self, worlds: Sequence[int], names: Sequence[str] | None = None) -> None:
        """Copy the records of these worlds to the GPU, or only the arrays of these names."""
        host = {name: array for name, array in self._host().items() if name != "rewards"}
        if any(self.arrays[name].shape != array.shape for name, array in host.items()):
            raise ConfigError(
                "device='cuda': the scenario of an episode has more obstacles or more neighbours"
                " of a robot than its GPU arrays have room for; start with the largest scenario,"
                " or use device='cpu'"
            )
        for first, last in consecutive(worlds):
            for name, array in host.items():
                if array.size and (names is None or name in names):
                    self.memory.write(self.arrays[name][first:last], array[first:last])

    def download(self) -> Loop:
        """Copy the records that ticks change from the GPU, and return the loop on the CPU."""
        host, self.loop.is_blank = self._host(), False
        for name in STATE_ARRAYS:
            host[name][...] = self.memory.read(self.arrays[name])
        return self.loop

    def check(self) -> None:
        """Raise errors since the last call, as `Loop.check` does; this waits for the GPU."""
        if self.memory.read(self.errors[-1:])[0]:
            self.world.errors[...] = self.memory.read(self.errors)
            self.memory.write(self.errors, np.zeros_like(self.world.errors))
            self.download()
            self.loop.check()

    def _host(self) -> dict[str, Array]:
        """Return the arrays on the CPU, as views."""
        world, layers = self.loop.world, self.layers
        arrays = dict(zip(WORLD, world.arrays, strict=True))
        arrays["cells"] = np.zeros((world.n_worlds, 0), np.int32)  # a GPU uses no cells
        return arrays | dict(zip(LAYERS, layers.arrays, strict=True))


def placed(loop: Loop, device: str) -> Loop | DeviceLoop:
    """Return the loop on its device; ConfigError for what does not run there."""
    return loop if checked_device(device) == "cpu" else DeviceLoop(loop)


WORLD = "robots", "worlds", "near", "cells", "obstacles", "rewards", "faults"
"""Names of the world's arrays, in the order in which templates receive them."""

LAYERS = "minds", "memories", "shared", "settings"
"""Names of the controller's arrays, in the order in which templates receive them."""

INPUTS = {
    "decide": ("robots", "minds", "memories", "shared", "settings"),
    "tick": ("robots", "worlds", "near", "obstacles"),
    "observe": ("robots", "minds", "shared", "settings"),
}
"""Arrays that each stage of a tick reads."""

OUTPUTS = {
    "decide": ("robots", "minds", "memories"),
    "tick": ("robots", "worlds", "near"),
    "observe": ("robots", "minds"),
}
"""Arrays that each stage of a tick writes."""

STATE_ARRAYS = "robots", "worlds", "minds", "memories", "faults"
"""Arrays that ticks change and later ticks read."""

PARAMETER_ARRAYS = "worlds", "obstacles", "faults", "settings"
"""Arrays that hold parameters of a scenario."""


def grid_of(n_worlds: int, n_robots: int) -> Grid:
    """Return the number of blocks, and the threads of a block (robots, worlds).

    >>> grid_of(10_000, 10)
    (834, (10, 12))
    >>> grid_of(1000, 10)
    (167, (10, 6))
    >>> grid_of(3, 1000)
    (3, (128, 1))
    """
    robots = min(n_robots, MAX_THREADS)
    worlds = min(max(n_worlds // ENOUGH_BLOCKS, 1), MAX_THREADS // robots)
    return -(-n_worlds // worlds), (robots, worlds)


def _layers_of(loop: Loop) -> tuple[CompiledLayers, Mapping[str, Kernel]]:
    """Return a loop's layers and GPU functions; ConfigError for what runs on a CPU only."""
    if loop.task.gpu is None:
        raise ConfigError(
            f"device='cuda': the task {loop.task.name} runs on a CPU only; use device='cpu'"
        )
    if loop.physics != "kinematic":
        raise ConfigError(
            f"device='cuda': the engine {loop.physics} calls a library that runs on a CPU only;"
            " use physics='kinematic'"
        )
    loop.controller.check_on_gpu()
    return loop.controller.compiled, loop.task.gpu
