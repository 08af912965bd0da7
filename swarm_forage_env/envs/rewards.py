"""Rewards: individual and team rewards, user-defined rewards, and shaping.

A user-defined reward is a callable. It is called after each tick with the records of the robots
before and after the tick and with its events, all of shape (worlds, robots):

    def gentle(before, after, events):
        return events["trip"] - 0.01 * events["contact"]
"""

from collections.abc import Callable
from typing import cast

import numpy as np
from numpy.typing import ArrayLike

from swarm_forage_env.arrays import Array, Float64, read_only
from swarm_forage_env.compiler import inlined
from swarm_forage_env.errors import ConfigError, shown
from swarm_forage_env.loop import Loop
from swarm_forage_env.task import Task

REWARDS = "own", "team"
"""Rewards by name: each robot's own, 1 for completing nest -> prey -> nest; or the mean over
the robots of its world."""


@inlined
def mean_of(rewards: Float64[Array, " robots"]) -> float:
    """Return the mean over the robots of a world, summed in their order."""
    total = 0.0
    for i in range(rewards.shape[0]):
        total += rewards[i]
    return float(total / rewards.shape[0])


@inlined
def shaping(before: float, after: float, discount: float, weight: float) -> float:
    """Return the shaping reward of a step between states with these potentials.

        weight (discount Phi' - Phi)

    It leaves the optimal policies unchanged.

    Source: Ng1999, Theorem 1.
    """
    return weight * (discount * after - before)


class OwnReward:
    """User-defined reward, called after every tick."""

    def __init__(self, loop: Loop, reward: object) -> None:
        self._loop, self._reward = loop, _callable(reward, loop.task)
        assert loop.task.events is not None
        self._write_events = loop.task.events.write
        self._events = loop.task.events.array(loop.world.robots.shape)

    def run(self, n_ticks: int) -> None:
        """Run ticks, and write the sum of each robot's rewards to `world.rewards`."""
        world = self._loop.world
        total = np.zeros_like(world.rewards)
        for _ in range(n_ticks):
            before = world.robots.copy()
            self._loop.step()
            self._write_events(world, before, self._events)
            rewards = self._reward(*map(read_only, (before, world.robots, self._events)))
            total += _checked(rewards, world.robots.shape)
        world.rewards[...] = total


def _callable(reward: object, task: Task) -> Callable[[Array, Array, Array], object]:
    if not callable(reward):
        known = ", ".join(f"'{name}'" for name in REWARDS)
        raise ConfigError(
            f"reward={reward!r}: must be {known}, or callable with the records before and after a"
            " tick and its events"
        )
    if task.events is None:
        raise ConfigError(
            f"reward={reward!r}: the task {task.name} reports no events to a callable; use a"
            " reward by name"
        )
    return reward


def _checked(rewards: object, shape: tuple[int, ...]) -> Float64[Array, "worlds robots"]:
    try:
        array = np.asarray(cast(ArrayLike, rewards), np.float64)
    except (TypeError, ValueError):
        given = shown(rewards)
        raise ConfigError(f"reward: gave {given}, must be numbers of shape {shape}") from None
    if array.shape != shape:
        raise ConfigError(f"reward: gave shape {array.shape}, must be {shape}, worlds by robots")
    if not np.isfinite(array).all():
        where = tuple(int(k) for k in np.argwhere(~np.isfinite(array))[0])
        raise ConfigError(
            f"reward: gave {array[where]} to robot {where[1]} of world {where[0]}; must be finite"
        )
    return array
