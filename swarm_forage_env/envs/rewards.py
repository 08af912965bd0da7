"""Rewards: who is credited with what a robot earned, one of the user's own, and shaping.

A reward of the user's own is an object that is called after each tick with the records of the
robots before and after it and with its events, all of shape (worlds, robots):

    def gentle(before, after, events):
        return events["trip"] - 0.01 * events["contact"]
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.compiler import entry_point, inlined
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.registry import Registry
from swarm_forage_env.task import Task, World

Reward = Callable[[Float64[Array, "worlds robots"]], Float64[Array, "worlds robots"]]

REWARDS: Registry[Reward] = Registry("reward")
"""Rewards by name: from what each robot earned to what each is given."""


@REWARDS.register("own")
def own(earned: Float64[Array, "worlds robots"]) -> Float64[Array, "worlds robots"]:
    """Each robot gets what it earned: 1 for completing nest -> prey -> nest."""
    return earned


@REWARDS.register("team")
def team(earned: Float64[Array, "worlds robots"]) -> Float64[Array, "worlds robots"]:
    """Every robot gets the mean over the robots of its world."""
    means = np.empty(len(earned))
    write_means(np.ascontiguousarray(earned), means)
    return np.broadcast_to(means[:, None], earned.shape)


@inlined
def mean_of(earned: Float64[Array, " robots"]) -> float:
    """The mean over the robots of a world, added up in their order."""
    total = 0.0
    for i in range(earned.shape[0]):
        total += earned[i]
    return float(total / earned.shape[0])


@entry_point
def write_means(earned: Float64[Array, "worlds robots"], out: Float64[Array, " worlds"]) -> None:
    """Write the mean of every world."""
    for w in range(out.shape[0]):
        out[w] = mean_of(earned[w])


@inlined
def shaping(before: float, after: float, discount: float, weight: float) -> float:
    """What a step between states of these potentials adds to the reward.

        weight (discount Phi' - Phi)

    The optimal policies stay as they are.

    Source: Ng1999, Theorem 1.
    """
    return weight * (discount * after - before)


@entry_point
def add_shaping(
    rewards: Float64[Array, " rows"],
    before: Float64[Array, " rows"],
    after: Float64[Array, " rows"],
    discount: float,
    weight: float,
) -> None:
    """Add to every reward what shaping adds to it."""
    for row in range(rewards.shape[0]):
        rewards[row] += shaping(before[row], after[row], discount, weight)


class EarnedInTick:
    """What every robot earned in a tick: the task's reward, or the user's own."""

    def __init__(self, world: World, task: Task, reward: Any) -> None:  # noqa: ANN401 a name or a callable
        """The reward of a name, or the given one; ConfigError or UnknownNameError for others."""
        self._world, self._task = world, task
        self._own = None if isinstance(reward, str) else _callable(reward, task)
        self.credit = REWARDS[reward] if isinstance(reward, str) else own
        if self._own is not None and task.events is not None:
            self._events = task.events.array(world.robots.shape)
            self._before = world.robots.copy()

    @property
    def is_own(self) -> bool:
        """The reward is the user's own: it is asked in Python after each tick."""
        return self._own is not None

    def remember(self) -> None:
        """Keep the records of the robots before a tick."""
        self._before[...] = self._world.robots

    def in_tick(self) -> Float64[Array, "worlds robots"]:
        """What every robot earned in the tick since `remember`, by the user's own reward."""
        assert self._own is not None
        assert self._task.events is not None
        self._task.events.write(self._world, self._before, self._events)
        rewards = self._own(self._before, self._world.robots, self._events)
        return _checked(rewards, self._world.robots.shape)


def _callable(reward: Any, task: Task) -> Callable[[Array, Array, Array], Any]:  # noqa: ANN401
    """A reward of the user's own; ConfigError or UnknownNameError if it cannot be called."""
    if not callable(reward):
        known = ", ".join(f"'{name}'" for name in REWARDS)
        raise ConfigError(
            f"reward={reward!r}: must be {known}, or callable with the records before and after a"
            " tick and its events"
        )
    if task.events is None:
        raise ConfigError(f"reward={reward!r}: the task {task.name} tells no events; take a name")
    found: Callable[[Array, Array, Array], Any] = reward
    return found


def _checked(found: Any, shape: tuple[int, ...]) -> Float64[Array, "worlds robots"]:  # noqa: ANN401
    """A number for each robot; ConfigError for anything else."""
    try:
        earned = np.asarray(found, np.float64)
    except (TypeError, ValueError):
        raise ConfigError(f"reward: gave {found!r}, must be numbers of shape {shape}") from None
    if earned.shape != shape:
        raise ConfigError(f"reward: gave shape {earned.shape}, must be {shape}, worlds by robots")
    if not np.isfinite(earned).all():
        where = tuple(int(k) for k in np.argwhere(~np.isfinite(earned))[0])
        raise ConfigError(
            f"reward: gave {earned[where]} to robot {where[1]} of world {where[0]}; must be finite"
        )
    return earned
