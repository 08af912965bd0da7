"""What an environment does in a step: so many ticks, or ticks until robots exchange."""

from typing import Protocol

import numpy as np

from swarm_forage_env.arrays import Array, Bool, Float64
from swarm_forage_env.envs.episodes import Episodes
from swarm_forage_env.envs.rewards import EarnedInTick
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.loop import Loop
from swarm_forage_env.policy_interface import Index

Earned = Float64[Array, "worlds robots"]


class Stepper(Protocol):
    """Runs the worlds from one decision to the next."""

    ticks: int
    """How many were run, over all worlds."""

    def run(self, earned: EarnedInTick) -> Earned:
        """Run, count the step, and return what every robot earned in these ticks."""
        ...

    def acts(self) -> Bool[Array, "worlds robots"] | None:
        """Whose next action counts; None: everybody's."""
        ...


class Ticks:
    """Every step is so many ticks, in which an action is held."""

    def __init__(self, loop: Loop, episodes: Episodes, n_ticks: int) -> None:
        """A decision period of so many ticks."""
        self.ticks = 0
        self._loop, self._episodes, self._n_ticks = loop, episodes, n_ticks

    def run(self, earned: EarnedInTick) -> Earned:
        """Run, count the step, and return what every robot earned in these ticks."""
        world = self._loop.world
        total = world.earned
        total[...] = 0.0
        if earned.is_own:
            total = np.zeros(world.robots.shape)
            for _ in range(self._n_ticks):
                earned.remember()
                self._loop.step()
                total += earned.in_tick()
        else:
            self._loop.run(self._n_ticks)
        self._episodes.steps += 1
        self.ticks += self._n_ticks * world.n_worlds
        return total.copy()

    def acts(self) -> Bool[Array, "worlds robots"] | None:
        """Everybody's action counts."""
        return None


class Exchanges:
    """Every step runs each world to the end of the next exchange of one of its learners.

    A world whose time is up stops without one. The worlds need not step for equally long: what an
    episode counts is ticks.
    """

    def __init__(self, loop: Loop, episodes: Episodes, learners: Index) -> None:
        """Exchanges of these robots of every world; ConfigError if a world cannot run alone."""
        if loop.controller.has_rules:
            raise ConfigError(
                "step_on='exchange': worlds run on their own, and a layer of this controller is a"
                " rule on all of them, as learned ones are; take one whose motion is compiled"
            )
        self.ticks = 0
        self._loop, self._episodes, self._learners = loop, episodes, learners

    def run(self, earned: EarnedInTick) -> Earned:
        """Run, count the step, and return what every robot earned in these ticks."""
        world = self._loop.world
        total = np.zeros(world.robots.shape)
        rewards, ticks = world.robots["reward"], world.worlds["ticks"]
        is_valid = self._loop.controller.minds["estimator"]["exchange"]["is_valid"]
        for w, end in enumerate(self._episodes.ends.tolist()):
            while True:
                self._loop.step_worlds(w, w + 1)
                total[w] += rewards[w]
                if ticks[w] >= end or is_valid[w, self._learners].any():
                    break
        self.ticks += int((ticks - self._episodes.steps).sum())
        self._episodes.steps[:] = ticks
        return total

    def acts(self) -> Bool[Array, "worlds robots"]:
        """Those who just ended an exchange, and learn."""
        found = np.zeros(self._loop.world.robots.shape, np.bool_)
        minds = self._loop.controller.minds["estimator"]
        found[:, self._learners] = minds["exchange"]["is_valid"][:, self._learners]
        return found
