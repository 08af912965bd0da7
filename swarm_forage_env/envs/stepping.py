"""What an environment does in a step: so many ticks, or ticks until robots exchange."""

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from swarm_forage_env.arrays import Array, Bool, Float64
from swarm_forage_env.envs.episodes import Episodes
from swarm_forage_env.envs.rewards import EarnedInTick
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.loop import Loop

Earned = Float64[Array, "worlds robots"]


class Stepper(Protocol):
    """Runs the worlds from one decision to the next."""

    def run(self, loop: Loop, earned: EarnedInTick) -> Earned:
        """Run, and return what every robot earned in these ticks."""
        ...

    def acts(self, loop: Loop) -> Bool[Array, "worlds robots"] | None:
        """Whose next action counts; None: everybody's."""
        ...

    def count(self, loop: Loop, episodes: Episodes) -> None:
        """Count the step."""
        ...


class Ticks:
    """Every step is so many ticks, in which an action is held."""

    def __init__(self, n_ticks: int) -> None:
        """A decision period."""
        self._n_ticks = n_ticks

    def run(self, loop: Loop, earned: EarnedInTick) -> Earned:
        """Run, and return what every robot earned in these ticks."""
        total = np.zeros((loop.world.n_worlds, loop.world.n_robots))
        for _ in range(self._n_ticks):
            earned.remember()
            loop.step()
            total += earned()
        return total

    def acts(self, loop: Loop) -> Bool[Array, "worlds robots"] | None:
        """Everybody's action counts."""
        return None

    def count(self, loop: Loop, episodes: Episodes) -> None:
        """One more."""
        episodes.steps += 1


class Exchanges:
    """Every step runs each world to the end of the next exchange of one of its learners.

    A world whose time is up stops without one. The worlds need not step for equally long.
    """

    def __init__(self, loop: Loop, learners: Sequence[int]) -> None:
        """Exchanges of these robots of every world; ConfigError if a world cannot run alone."""
        if loop.controller.has_rules:
            raise ConfigError(
                "step_on='exchange': worlds run on their own, and a layer of this controller is a"
                " rule on all of them, as learned ones are; take one whose motion is compiled"
            )
        self._learners = np.asarray(learners)

    def run(self, loop: Loop, earned: EarnedInTick) -> Earned:
        """Run, and return what every robot earned in these ticks."""
        total = np.zeros((loop.world.n_worlds, loop.world.n_robots))
        for world in range(loop.world.n_worlds):
            while True:
                loop.step_worlds(world, world + 1)
                total[world] += loop.world.robots["reward"][world]
                if loop.world.is_over[world] or self._is_valid(loop)[world].any():
                    break
        return total

    def acts(self, loop: Loop) -> Bool[Array, "worlds robots"]:
        """Those who just ended an exchange, and learn."""
        found = np.zeros(loop.world.robots.shape, np.bool_)
        found[:, self._learners] = self._is_valid(loop)
        return found

    def count(self, loop: Loop, episodes: Episodes) -> None:
        """A step takes as many ticks as it takes: an episode's time is up when theirs is."""
        episodes.steps[:] = loop.world.worlds["ticks"]

    def _is_valid(self, loop: Loop) -> Bool[Array, "worlds learners"]:
        minds = loop.controller.minds["estimator"]
        return np.asarray(minds["exchange"]["is_valid"][:, self._learners])
