"""The control loop: decide, tick, observe, over a block of worlds and on several threads.

    controller.decide -> world.tick -> controller.observe -> [the cut] -> controller.decide ...

At the cut a learner writes `world.robots["action"]`, which takes the place of a layer.
"""

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import Any

import numpy as np

from swarm_forage_env.errors import ConfigError
from swarm_forage_env.interface import Controller, RunningController
from swarm_forage_env.scene import Scene
from swarm_forage_env.task import World, check_fit, checked_worlds, consecutive, one_task


class Loop:
    """A block of worlds and the controller of all their robots, in turn.

    The result does not depend on the number of threads: each runs its own worlds.
    """

    def __init__(
        self,
        scenario: Any,  # noqa: ANN401 of any task; or one for each seed
        controller: Controller | Sequence[Controller],
        seeds: Sequence[int],
        physics: str | None = None,
        threads: int = 1,
    ) -> None:
        """One world for each seed, sensed and about to move.

        `scenario` and `controller` are one for all worlds or one for each; they may differ in
        every number but how many robots there are.
        """
        scenarios = _one_each(scenario, seeds)
        self.task = one_task(scenarios)
        self.world: World = self.task.world(scenarios, seeds, physics or self.task.physics)
        controllers = _one_each(controller, seeds)
        build = controllers[0].build
        self.controller: RunningController = build(self.world, seeds, controllers)
        self.threads = checked_threads(threads)
        self._chunks = chunks(self.world.n_worlds, self.threads)
        self._begin(range(self.world.n_worlds), seeds)

    def reset(
        self,
        seeds: Sequence[int],
        worlds: Sequence[int] | None = None,
        scenarios: Any = None,  # noqa: ANN401 of its task
    ) -> None:
        """Start worlds anew, each from its seed: those of these indices, or all.

        With `scenarios`, one for all of these worlds or one for each, they have other numbers from
        now on. The other worlds go on untouched. ConfigError, before anything changes, for what
        does not fit.
        """
        which = checked_worlds(worlds, self.world.n_worlds)
        if scenarios is None:
            self.world.reset(seeds, which)
        else:
            self._reset_under(_one_each(scenarios, which), seeds, which)
        self._begin(which, seeds)

    def _reset_under(
        self, scenarios: Sequence[Any], seeds: Sequence[int], which: Sequence[int]
    ) -> None:
        """Start some worlds anew, each from its seed under another scenario."""
        check_fit([self.world.scenarios[w] for w in which], scenarios)
        numbers = [
            self.controller.numbers_in(w, scenario)
            for w, scenario in zip(which, scenarios, strict=True)
        ]
        self.world.reset(seeds, which, scenarios)
        for w, each in zip(which, numbers, strict=True):
            self.controller.renumber(w, each)

    def step(self) -> None:
        """One tick of every world.

        Afterwards `exchange` and `situation` hold what either layer is shown next.
        """
        self.controller.consult()
        self._run(self._step)

    def step_worlds(self, first: int, last: int) -> None:
        """One tick of the worlds first .. last - 1 alone, in which no rule in NumPy is asked."""
        self._step(first, last)

    @property
    def exchange(self) -> Any:  # noqa: ANN401 of its task
        """What the weighting layer of every robot sees, a row for each."""
        return self.task.exchange(self.world, self.controller.minds)

    @property
    def situation(self) -> Any:  # noqa: ANN401 of its task
        """What the motion layer of every robot sees, a row for each."""
        return self.task.situation(self.world, self.controller.minds)

    def scene(self, which: int = 0) -> Scene:
        """What is drawn of one world as it stands; ConfigError if its task has no drawing."""
        if self.task.scene is None:
            raise ConfigError(f"the task {self.task.name} has no drawing")
        return self.task.scene(self.world, self.controller.minds, which)

    def _begin(self, which: Sequence[int], seeds: Sequence[int]) -> None:
        """Let the controller forget some worlds, and take in what is sensed first."""
        for world, seed in zip(which, seeds, strict=True):
            self.controller.reset(world, seed)
        for first, last in consecutive(which):
            self.controller.observe(first, last)

    def _step(self, first: int, last: int) -> None:
        self.controller.decide(first, last)
        self.world.tick(first, last)
        self.controller.observe(first, last)

    def _run(self, work: Callable[[int, int], None]) -> None:
        """Do a piece of work on all worlds, one chunk of them on each thread.

        The thread that asks does the first chunk itself: waking another costs tens of us.
        """
        own, *others = self._chunks
        waiting = [pool(self.threads).submit(work, *chunk) for chunk in others]
        work(*own)
        for each in waiting:
            each.result()


@cache
def _pool_of(threads: int, process: int) -> ThreadPoolExecutor:
    return ThreadPoolExecutor(threads, thread_name_prefix="swarm-forage")


def pool(threads: int) -> ThreadPoolExecutor:
    """The pool of this process, kept for all blocks of so many threads; a fork makes its own."""
    return _pool_of(threads, os.getpid())


def chunks(n_worlds: int, threads: int) -> list[tuple[int, int]]:
    """Consecutive worlds for each thread: first and last + 1.

    >>> chunks(5, 2)
    [(0, 3), (3, 5)]
    """
    parts = np.array_split(np.arange(n_worlds), min(threads, n_worlds))
    return [(int(part[0]), int(part[-1]) + 1) for part in parts]


def checked_threads(threads: Any) -> int:  # noqa: ANN401 whatever was given
    """The number of threads; ConfigError for what is none."""
    if isinstance(threads, int) and not isinstance(threads, bool) and threads >= 1:
        return threads
    raise ConfigError(f"threads={threads!r}: must be a whole number, at least 1")


def _one_each(given: Any, worlds: Sequence[int]) -> list[Any]:  # noqa: ANN401 scenarios or controllers
    """One for each world; ConfigError for a list of another length."""
    if not isinstance(given, list | tuple):
        return [given] * len(worlds)
    if len(given) != len(worlds):
        raise ConfigError(f"{len(given)} given for {len(worlds)} worlds: must be one for each")
    return list(given)
