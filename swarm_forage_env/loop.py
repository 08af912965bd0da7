"""The control loop: decide, tick, observe, over a block of worlds and on several threads.

    controller.decide -> world.tick -> controller.observe -> [the cut] -> controller.decide ...

At the cut a learner writes `world.robots["action"]`, which takes the place of a layer.
"""

import os
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from dataclasses import dataclass
from functools import cache, partial
from typing import Any, TypeVar, cast

import numpy as np

from swarm_forage_env import task
from swarm_forage_env.compiler import bind, typed_once
from swarm_forage_env.errors import ConfigError, checked_count
from swarm_forage_env.interface import Controller, Kernel, RunningController
from swarm_forage_env.mixed import MixedController, build, members_of
from swarm_forage_env.parameters import BaseScenario
from swarm_forage_env.raw_control import estimators_of
from swarm_forage_env.record import Rows, copied_rows
from swarm_forage_env.scene import Scene
from swarm_forage_env.task import World
from swarm_forage_env.ticks import RUNS, STAGES, Modes, Trouble, only, run_ticks
from swarm_forage_env.worlds_on_cpu import WorldsOnCpu

EachT = TypeVar("EachT")


@dataclass(frozen=True)
class Snapshot:
    """A block of worlds and its controller in mid-episode, to be pickled and restored anywhere."""

    kind: str
    """Task, engine and controller; how many worlds, and robots in each."""
    world: Mapping[str, Any]
    """What the worlds were."""
    controller: Any
    """What the robots believed and remembered, with the numbers of their layers."""


class Loop(WorldsOnCpu):
    """A block of worlds and the controller of all their robots, in turn.

    The result does not depend on the number of threads: each runs its own worlds. A copy, by
    `copy.deepcopy` or by pickle, goes on from the same tick, bit for bit.

    >>> from swarm_forage_env.controllers import find_controller
    >>> from swarm_forage_env.scenarios import find_scenario
    >>> loop = Loop(find_scenario("near"), find_controller("ssgikf"), seeds=range(4))
    >>> loop.run(10)
    >>> loop.world.robots["pose"].shape  # worlds, robots, and x, y, heading
    (4, 5, 3)
    """

    def __init__(
        self,
        scenario: BaseScenario | Sequence[BaseScenario],
        controller: Controller | Sequence[Controller],
        seeds: Sequence[int],
        physics: str | None = None,
        threads: int = 1,
        is_blank: bool = False,
    ) -> None:
        """One world for each seed, sensed and about to move.

        `scenario` and `controller` are one for all worlds or one for each; they may differ in
        every number but how many robots there are. Robots of different controllers in one world
        are a `MixedController`. A block that `is_blank` has one scenario and one controller, and
        nobody in it has a place before a reset.
        """
        scenarios = _one_each(scenario, seeds)
        self.task = task.one_task(scenarios)
        self.physics = physics or self.task.physics
        self.world: World = self.task.world(scenarios, () if is_blank else seeds, self.physics)
        self.is_blank = is_blank
        """All worlds are as the first."""
        controllers = _one_each(controller, seeds)
        mixed = (each for each in controllers if isinstance(each, MixedController))
        leader = next(mixed, controllers[0])
        self.controllers, self._name = controllers, str(leader.name)
        self.controller: RunningController = build(self.world, seeds, controllers)
        super().__init__(self.world, self.controller.minds)
        self.threads = checked_count("threads", threads)
        self._chunks = chunks(self.world.n_worlds, self.threads)
        self._layers = self.controller.compiled
        self._kernels: dict[tuple[str, ...], Kernel] = {}
        if not is_blank:
            self._begin(dict(enumerate(seeds)))

    def reset(
        self,
        seeds: Sequence[int],
        worlds: Sequence[int] | None = None,
        scenarios: BaseScenario | Sequence[BaseScenario] | None = None,
    ) -> None:
        """Reset worlds, each from its seed: those of these indices, or all.

        With `scenarios`, one for all of these worlds or one for each, they have other numbers from
        now on. The other worlds go on untouched. ConfigError, before anything changes, for what
        does not fit.
        """
        seed_of = self.world.seed_of(seeds, worlds)
        which = [*seed_of]
        if scenarios is not None:
            self.renumber(_one_each(scenarios, which), which)
        self.world.reset(seeds, which)
        self._begin(seed_of)

    def renumber(self, scenarios: Sequence[BaseScenario], which: Sequence[int]) -> None:
        """Give worlds the numbers of other scenarios; ConfigError, before anything changes."""
        task.check_fit([self.world.scenarios[w] for w in which], scenarios)
        numbers = [
            self.controller.numbers_in(w, scenario)
            for w, scenario in zip(which, scenarios, strict=True)
        ]
        self.world.replace_scenarios(which, scenarios)
        for w, each in zip(which, numbers, strict=True):
            self.controller.renumber(w, each)

    def download(self) -> "Loop":
        """The loop itself: what a loop of a GPU copies back is here already."""
        return self

    def step(self) -> None:
        """One tick of every world: `exchange` and `situation` are what layers are shown next."""
        self.run(1)

    def run(self, n_ticks: int, modes: Modes | None = None) -> None:
        """Some ticks of every world, in one compiled call where no Python must come in between.

        `modes` is STANDS or RUNS for each world; by default all run. ConfigError for a command
        that is not finite, or a weight that is no share.
        """
        is_stepped = self.controller.has_rules or not self.world.is_compiled
        at_once = 1 if is_stepped else max(n_ticks, 1)
        chosen = self.world.modes if modes is None else modes
        for _ in range(n_ticks // at_once):
            self.controller.consult()
            self._on_all_threads(partial(self._advance, at_once, chosen))
            self.check()

    def snapshot(self) -> Snapshot:
        """All that the next ticks depend on, to be restored any number of times."""
        return Snapshot(self._kind, self.world.snapshot(), self.controller.snapshot())

    def restore(self, snapshot: Snapshot) -> None:
        """Go on as when the snapshot was taken, bit for bit; ConfigError if it does not fit."""
        if snapshot.kind != self._kind:
            raise ConfigError(f"a snapshot of {snapshot.kind}, cannot be restored in {self._kind}")
        scenarios = snapshot.world["scenarios"]
        task.check_fit(self.world.scenarios, scenarios)
        self.is_blank = False
        self.world.restore(snapshot.world)
        self.controller.restore(snapshot.controller)

    def __getstate__(self) -> dict[str, Any]:
        """What makes the same loop again, and how it stands."""
        made_by = self.controllers, self.physics, self.threads
        return {"made_by": made_by, "snapshot": self.snapshot()}

    def __setstate__(self, state: Mapping[str, Any]) -> None:
        """A copy of the loop, compiled again, which continues where this one is."""
        controllers, physics, threads = state["made_by"]
        scenarios = list(state["snapshot"].world["scenarios"])
        Loop.__init__(self, scenarios, controllers, range(len(scenarios)), physics, threads)
        self.restore(state["snapshot"])

    @property
    def _kind(self) -> str:
        return (
            f"the task {self.task.name}, engine {self.physics}, controller {self._name},"
            f" {self.world.n_worlds} worlds of {self.world.n_robots} robots"
        )

    @property
    def exchange(self) -> Rows:
        """A copy of what the weighting layer of every robot sees; ConfigError if none has one."""
        return self._estimated("exchange")

    @property
    def situation(self) -> Rows:
        """The same of what the motion layer sees of a robot's beliefs."""
        return self._estimated("situation")

    def _estimated(self, name: str) -> Rows:
        shown: Rows = copied_rows(estimators_of(self.controller.minds), (name,))
        return shown

    def scene(self, which: int = 0) -> Scene:
        """What is drawn of one world as it stands; ConfigError if its task has no drawing."""
        if self.task.scene is None:
            raise ConfigError(f"the task {self.task.name} has no drawing")
        return self.task.scene(self.world, self.controller.minds, which)

    def _begin(self, seed_of: Mapping[int, int]) -> None:
        """Let the controller forget the worlds of these seeds, then sense and observe in them."""
        self.is_blank = False
        stages = tuple(STAGES) if self.world.is_compiled else AFTER_ENGINE
        for first, last in task.consecutive([*seed_of]):
            self.controller.reset(first, last, [seed_of[w] for w in range(first, last)])
            self._call(stages, 1, self.world.beginning, first, last)
        self.check()

    def run_stages(self, *stages: str, first: int = 0, last: int | None = None) -> None:
        """Run some stages of one tick alone, of `ticks.STAGES`, in the worlds first .. last - 1."""
        end = self.world.n_worlds if last is None else last
        self._call(stages, 1, self.world.modes, first, end)

    def _call(
        self, stages: tuple[str, ...], n_ticks: int, modes: Modes, first: int, last: int
    ) -> None:
        """Run ticks, or stages of them, of world and controller in one compiled call."""
        world, layers = self.world, self._layers
        if stages not in self._kernels:
            functions = {**world.functions, **layers.functions, **only(*stages)}
            self._kernels[stages] = typed_once(bind(run_ticks, functions))
        kernel = self._kernels[stages]
        kernel(world.arrays, layers.arrays, modes, world.trouble, first, last, n_ticks)

    def _advance(self, n_ticks: int, modes: Modes, first: int, last: int) -> None:
        """Some ticks of those of the worlds first .. last - 1 that run."""
        if self.world.is_compiled:
            self._call(tuple(STAGES), n_ticks, modes, first, last)
            return
        for begin, end in task.consecutive([w for w in range(first, last) if modes[w] == RUNS]):
            self.run_stages("decide", first=begin, last=end)
            if not self.world.trouble[-1]:
                self.world.move(begin, end)
                self.run_stages(*AFTER_ENGINE, first=begin, last=end)

    @property
    def trouble(self) -> Trouble:
        """What went wrong in each world since `check` was called."""
        return self.world.trouble

    def check(self) -> None:
        """Raise what went wrong in a tick, once."""
        if self.world.trouble[-1]:
            each = [members_of(own, self.world.n_robots) for own in self.controllers]
            raise task.trouble_in(self.world, lambda w, robot: str(each[w][robot].name))

    def _on_all_threads(self, work: Callable[[int, int], None]) -> None:
        """Do a piece of work on all worlds, one chunk of them on each thread.

        The thread that asks does the first chunk itself: waking another costs tens of us.
        """
        own, *others = self._chunks
        waiting = [pool(self.threads).submit(work, *chunk) for chunk in others]
        try:
            work(*own)
            for each in waiting:
                each.result()
        except BaseException:
            wait(waiting)  # no thread may go on in these worlds when the error is told
            raise


AFTER_ENGINE = "tick", "observe"
"""What follows an engine in Python in a tick."""


@cache
def _pool_of(threads: int, process: int) -> ThreadPoolExecutor:
    return ThreadPoolExecutor(threads, thread_name_prefix="swarm-forage")


def pool(threads: int) -> ThreadPoolExecutor:
    """The thread pool of this process and number of threads; a forked process makes its own."""
    return _pool_of(threads, os.getpid())


def chunks(n_worlds: int, threads: int) -> list[tuple[int, int]]:
    """Consecutive worlds for each thread: first and last + 1.

    >>> chunks(5, 2)
    [(0, 3), (3, 5)]
    """
    parts = np.array_split(np.arange(n_worlds), min(threads, n_worlds))
    return [(int(part[0]), int(part[-1]) + 1) for part in parts]


def _one_each(given: EachT | Sequence[EachT], worlds: Sequence[int]) -> list[EachT]:
    """One for each world; ConfigError for a list of another length."""
    if not isinstance(given, list | tuple):
        return [cast(EachT, given)] * len(worlds)
    if len(given) != len(worlds):
        raise ConfigError(f"{len(given)} given for {len(worlds)} worlds: must be one for each")
    return list(given)
