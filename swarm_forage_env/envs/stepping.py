"""What an environment does in a step: so many ticks, or ticks until robots exchange."""

from typing import Any, Protocol

import numpy as np

from swarm_forage_env.arrays import Array, Int64
from swarm_forage_env.device_loop import DeviceLoop
from swarm_forage_env.envs.decision_kernels import stop_at_exchanges, write_acts
from swarm_forage_env.envs.episodes import Episodes
from swarm_forage_env.envs.rewards import OwnReward
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.loop import Loop
from swarm_forage_env.ticks import RUNS

Worlds = Loop | DeviceLoop

LOOKED_AT_EVERY = 16
"""Ticks after which a CPU asks a GPU whether a world still runs, and waits for the answer."""


class Stepper(Protocol):
    """Runs the worlds from one decision to the next."""

    ticks: int
    """How many were run, over all worlds."""

    def run(self) -> None:
        """Run, and count the step; `earned` is what every robot earned in these ticks."""
        ...

    def acts(self) -> Any:  # noqa: ANN401 an array of the place
        """Whose next action counts: 1, else 0, worlds by learners; None: everybody's."""
        ...


class Ticks:
    """Every step is so many ticks, in which an action is held."""

    def __init__(
        self, worlds: Worlds, episodes: Episodes, n_ticks: int, reward: OwnReward | None
    ) -> None:
        """A decision period of so many ticks; a reward of the user's own is asked after each."""
        self.ticks = 0
        self._worlds, self._episodes, self._n_ticks = worlds, episodes, n_ticks
        self._reward = reward

    def run(self) -> None:
        """Run, and count the step; `earned` is what every robot earned in these ticks."""
        if self._reward is None:
            self._worlds.run(self._n_ticks)
        else:
            earned = self._worlds.arrays["earned"]
            total = np.zeros_like(earned)
            for _ in range(self._n_ticks):
                self._reward.remember()
                self._worlds.step()
                total += self._reward.in_tick()
            earned[...] = total
        self._episodes.steps += 1
        self.ticks += self._n_ticks * len(self._episodes.steps)

    def acts(self) -> None:
        """Everybody's action counts."""


class Exchanges:
    """Every step runs each world to the end of the next exchange of one of its learners.

    A world whose time is up stops without one. A world that has come so far stands still until all
    others have too: what an episode counts is ticks.
    """

    def __init__(
        self, worlds: Worlds, episodes: Episodes, learners: Int64[Array, " learners"]
    ) -> None:
        """Exchanges of these robots of every world; ConfigError if a world cannot run alone."""
        if isinstance(worlds, Loop) and worlds.controller.has_rules:
            raise ConfigError(
                "step_on='exchange': worlds run on their own, and a layer of this controller is a"
                " rule on all of them, as learned ones are; take one whose motion is compiled"
            )
        self.ticks = 0
        self._worlds, self._episodes, memory = worlds, episodes, worlds.memory
        self._learners = memory.to_device(learners)
        self._shape = len(episodes.steps), len(learners)
        self._modes = memory.to_device(np.zeros(self._shape[0], np.int8))
        self._ticks = memory.to_device(np.zeros(self._shape[0], np.int64))
        self._stop = worlds.kernel(stop_at_exchanges, {})
        self._acts = worlds.kernel(write_acts, {})

    def run(self) -> None:
        """Run, and count the ticks of each world."""
        worlds, episodes, memory, modes = (
            self._worlds,
            self._episodes,
            self._worlds.memory,
            self._modes,
        )
        at, ends = worlds.arrays, memory.to_device(episodes.ends)
        memory.write(modes, np.full(self._shape[0], RUNS, np.int8))
        for tick in range(1, int((episodes.ends - episodes.steps).max()) + 1):
            worlds.run(1, modes)
            self._stop(at["worlds"], at["minds"], self._learners, ends, modes, self._ticks)
            if tick % LOOKED_AT_EVERY == 0 and not memory.read(modes).any():
                break
        after = memory.read(self._ticks)
        self.ticks += int((after - episodes.steps).sum())
        episodes.steps[:] = after

    def acts(self) -> Any:  # noqa: ANN401 an array of the place
        """Those who just ended an exchange, and learn: 1, the others 0."""
        out = self._worlds.memory.empty(self._shape, np.float64)
        self._acts(self._worlds.arrays["minds"], self._learners, out)
        return out
