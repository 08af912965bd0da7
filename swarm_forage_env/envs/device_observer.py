"""What the learners of a GPU's worlds observe, and what they are given, as arrays of the GPU."""

from typing import Any

import numpy as np

from swarm_forage_env.compiler import bind_grid
from swarm_forage_env.device_loop import DeviceLoop
from swarm_forage_env.envs import grid
from swarm_forage_env.envs.array_env import ArrayEnv
from swarm_forage_env.interface import Kernel


class DeviceObserver:
    """Writes what every learner observes, a new array each time."""

    def __init__(self, host: ArrayEnv, loop: DeviceLoop) -> None:
        """As the environment on the CPU does."""
        self._host, self._loop, memory = host, loop, loop.memory
        self._learners = memory.to_device(host.learner_numbers)
        observer, shape = host.observer, (host.n_worlds, len(host.learners))
        self._shape, self._stack = shape, host.config.stack
        direction, bound, squashes = observer.on_grid
        self._direction = memory.to_device(direction)
        self._scaling = memory.to_device(bound), memory.to_device(squashes)
        self._show, self._fields = bind_grid(grid.show_layer, {}), loop.fields(observer.shown)
        self._parts = [
            (bind_grid(grid.add_part, {"put": part.put}), span)  # type: ignore[attr-defined]  # others are refused
            for part, span in zip(observer.parts, observer.spans, strict=True)
        ]
        self._normalise = bind_grid(grid.normalise, {})
        self._stack_frames = bind_grid(grid.stack_frames, {})
        self._n = len(observer.layout)
        kept = (*shape, self._stack if self._stack > 1 else 0, self._n)
        self.frames = memory.to_device(np.zeros(kept, np.float32))

    def __call__(self, raw: Any, is_new: Any, is_step: bool) -> Any:  # noqa: ANN401 arrays of the GPU
        """What every learner observes after actions, in a step or where some worlds are new."""
        loop, memory = self._loop, self._loop.memory
        on = loop.launch
        seen = memory.empty((*self._shape, self._n), np.float32)
        if self._host.observer.n_shown:
            self._show[on](*self._fields, self._learners, self._direction, seen)
        if self._parts:
            time_left = memory.to_device(self._host.episodes.share_left())
            n_robots = self._host.world.n_robots
            for add, span in self._parts:
                add[on](self._learners, n_robots, time_left, raw, *span, seen)
        if self._host.config.normalise:
            self._normalise[on](*self._scaling, seen)
        if self._stack == 1:
            return seen
        out = memory.empty((*self._shape, self._stack * self._n), np.float32)
        self._stack_frames[on](seen, is_new, is_step, self.frames, out)
        return out


class DeviceRewards:
    """What every learner is given, new arrays each time."""

    def __init__(self, host: ArrayEnv, potential: Kernel, loop: DeviceLoop) -> None:
        """As the environment on the CPU does."""
        self._config, self._loop, memory = host.config, loop, loop.memory
        self._learners = memory.to_device(host.learner_numbers)
        shape = host.world.robots.shape
        self.potentials = memory.to_device(np.zeros(shape))
        self._shaped = memory.to_device(np.zeros((2, *shape)))
        self._shape = host.n_worlds, len(host.learners)
        self._begin, self._credit = (
            bind_grid(template, {"potential": potential}) for template in (grid.begin, grid.credit)
        )

    def begin(self, is_new: Any, raw: Any) -> Any:  # noqa: ANN401 arrays of the GPU
        """Begin episodes in new worlds; what was given in them: nothing."""
        at = self._loop.arrays
        self._begin[self._loop.launch](at["robots"], at["worlds"], is_new, raw, self.potentials)
        return self._loop.memory.to_device(np.zeros(self._shape))

    def __call__(self) -> tuple[Any, Any]:
        """The reward without shaping, and with it."""
        at, config = self._loop.arrays, self._config
        out = self._loop.memory.empty((2, *self._shape), np.float64)
        self._credit[self._loop.launch](
            at["robots"], at["worlds"], self._learners, self._loop.earned, self.potentials,
            self._shaped, config.discount, config.shaping, config.reward == "team", out,
        )  # fmt: skip
        return out[0], out[1]
