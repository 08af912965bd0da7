"""What an environment on a GPU does in a step: so many ticks, or ticks until robots exchange."""

from typing import Any, Protocol

import numpy as np

from swarm_forage_env.compiler import bind_grid
from swarm_forage_env.device_loop import DeviceLoop
from swarm_forage_env.envs import grid
from swarm_forage_env.envs.array_env import ArrayEnv

LOOKED_AT_EVERY = 16
"""Ticks after which the CPU asks whether a world still runs, and waits for the answer."""


class DeviceStepper(Protocol):
    """Runs the worlds of a GPU from one decision to the next."""

    def run(self) -> None:
        """Run, and count the step."""
        ...

    def acts(self) -> Any:  # noqa: ANN401 an array of the GPU
        """Whose next action counts, a new array; None: everybody's."""
        ...


class DeviceTicks:
    """Every step is so many ticks, in which an action is held."""

    def __init__(self, host: ArrayEnv, loop: DeviceLoop) -> None:
        """The decision period of an environment."""
        self._loop, self._episodes, self._n_ticks = loop, host.episodes, host.config.period

    def run(self) -> None:
        """Run, and count the step."""
        self._loop.run(self._n_ticks)
        self._episodes.steps += 1

    def acts(self) -> None:
        """Everybody's action counts."""


class DeviceExchanges:
    """Every step runs each world to the end of the next exchange of one of its learners.

    As `Exchanges` of a CPU. A world that has come so far stands still, until all others have too.
    """

    def __init__(self, host: ArrayEnv, loop: DeviceLoop) -> None:
        """Exchanges of the learners of an environment."""
        self._loop, self._episodes = loop, host.episodes
        self._shape, memory = (host.n_worlds, len(host.learners)), loop.memory
        self._learners = memory.to_device(host.learner_numbers)
        self._all = np.ones(host.n_worlds, np.int8)
        self._runs = memory.to_device(self._all)
        self._ticks = memory.to_device(np.zeros(host.n_worlds, np.int64))
        self._stop, self._acts = (
            bind_grid(template, {}) for template in (grid.stop_at_exchanges, grid.write_acts)
        )

    def run(self) -> None:
        """Run, and count the ticks of each world."""
        loop, episodes, memory, runs = self._loop, self._episodes, self._loop.memory, self._runs
        at, ends = loop.arrays, memory.to_device(episodes.ends)
        memory.write(runs, self._all)
        for tick in range(1, int((episodes.ends - episodes.steps).max()) + 1):
            loop.step(runs)
            self._stop[loop.launch](
                at["worlds"], at["minds"], self._learners, ends, runs, self._ticks
            )
            if tick % LOOKED_AT_EVERY == 0 and not memory.read(runs).any():
                break
        episodes.steps[:] = memory.read(self._ticks)

    def acts(self) -> Any:  # noqa: ANN401 an array of the GPU
        """Those who just ended an exchange, and learn: 1, the others 0."""
        out = self._loop.memory.empty(self._shape, np.float64)
        self._acts[self._loop.launch](self._loop.arrays["minds"], self._learners, out)
        return out
