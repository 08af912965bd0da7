"""Steps that end where robots exchange."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from swarm_forage_env.arrays import Array, Int64
from swarm_forage_env.device_loop import DeviceLoop
from swarm_forage_env.envs.decision_kernels import stop_at_exchanges, write_acts
from swarm_forage_env.envs.episodes import Episodes
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.loop import Loop
from swarm_forage_env.ticks import RUNS
from swarm_forage_env.worlds_on_cpu import Memory, PlacedArray

Worlds = Loop | DeviceLoop

LOOKED_AT_EVERY = 16
"""Ticks after which a CPU asks a GPU whether a world still runs, and waits for the answer."""


class Exchanges:
    """Every step runs each world to the end of the next exchange of one of its learners.

    A world whose time is up stops without one. A world that has come so far stands still until all
    others have too: what an episode counts is ticks.
    """

    def __init__(
        self, worlds: Worlds, episodes: Episodes, learners: Int64[Array, " learners"]
    ) -> None:
        if isinstance(worlds, Loop) and worlds.controller.has_rules:
            raise ConfigError(
                "step_on='exchange': worlds run on their own, and a layer of this controller is a"
                " rule on all of them, as learned ones are; take one whose motion is compiled"
            )
        self._worlds, self._episodes = worlds, episodes
        memory: Memory = worlds.memory
        self._learners = memory.to_device(learners)
        self._shape = len(episodes.steps), len(learners)
        self._modes: Any = memory.to_device(np.zeros(self._shape[0], np.int8))
        self._ticks = memory.to_device(np.zeros(self._shape[0], np.int64))
        self._stop = worlds.kernel(stop_at_exchanges, {})
        self._acts = worlds.kernel(write_acts, {})

    def run(self) -> int:
        """Run, and count the ticks of each world; how many they were together."""
        worlds, episodes, modes = self._worlds, self._episodes, self._modes
        at: Mapping[str, Any] = worlds.arrays
        memory: Memory = worlds.memory
        ends = memory.to_device(episodes.ends)
        memory.write(modes, np.full(self._shape[0], RUNS, np.int8))
        for tick in range(1, int((episodes.ends - episodes.steps).max()) + 1):
            worlds.run(1, modes)
            self._stop(at["worlds"], at["minds"], self._learners, ends, modes, self._ticks)
            if tick % LOOKED_AT_EVERY == 0 and not memory.read(modes).any():
                break
        after = memory.read(self._ticks)
        n_ticks = int((after - episodes.steps).sum())
        episodes.steps[:] = after
        return n_ticks

    def acts(self) -> PlacedArray:
        """1 for the learners that just ended an exchange, whose next action counts; else 0."""
        out = self._worlds.memory.empty(self._shape, np.float64)
        self._acts(self._worlds.arrays["minds"], self._learners, out)
        return out
