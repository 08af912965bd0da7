"""The control loop: decide, tick and observe, for a block of worlds, on several threads.

    controller.decide -> world.tick -> controller.observe -> [the cut] -> controller.decide ...

At the cut, a learner can replace a layer by writing `world.robots["action"]`.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, TypeVar, cast

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
from swarm_forage_env.thread_team import ThreadTeam, serve
from swarm_forage_env.ticks import RUN, STAGES, Errors, Modes, only, run_ticks
from swarm_forage_env.worlds_on_cpu import WorldsOnCpu

EachT = TypeVar("EachT")


@dataclass(frozen=True)
class Snapshot:
    """State of a block of worlds and its controller, to be pickled and restored anywhere."""

    kind: str
    """Task, engine, controller, number of worlds, and number of robots in each."""
    world: Mapping[str, Any]
    """Snapshot of the worlds."""
    controller: Any
    """Snapshot of the controller: beliefs, memories and layer parameters of the robots."""


class Loop(WorldsOnCpu):
    """A block of worlds and the controller of all their robots.

    Results do not depend on the number of threads: each thread runs its own worlds. A copy, by
    `copy.deepcopy` or by pickle, continues from the same tick, bit for bit.

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
        """Create one world for each seed, with its first observations computed.

        `scenario` and `controller` are one for all worlds or one for each; their parameters may
        differ, but not the number of robots. A `MixedController` gives the robots of a world
        different controllers. A block that `is_blank` has one scenario and one controller, and its
        robots have no positions before a reset.
        """
        scenarios = _one_each(scenario, seeds)
        self.task = task.one_task(scenarios)
        self.physics = physics or self.task.physics
        self.world: World = self.task.world(scenarios, () if is_blank else seeds, self.physics)
        self.is_blank = is_blank
        """Whether all worlds are still equal to the first one, as no reset has placed robots."""
        controllers = _one_each(controller, seeds)
        mixed = (each for each in controllers if isinstance(each, MixedController))
        leader = next(mixed, controllers[0])
        self.controllers, self._name = controllers, str(leader.name)
        self.controller: RunningController = build(self.world, seeds, controllers)
        super().__init__(self.world, self.controller.minds)
        self.threads = checked_count("threads", threads)
        self._team = ThreadTeam(self.world.n_worlds, self.threads)
        self._layers = self.controller.compiled
        self._modes = self.world.modes.copy()
        self._kernels: dict[tuple[str, ...], Kernel] = {}
        if not is_blank:
            self._begin(dict(enumerate(seeds)))

    def reset(
        self,
        seeds: Sequence[int],
        worlds: Sequence[int] | None = None,
        scenarios: BaseScenario | Sequence[BaseScenario] | None = None,
    ) -> None:
        """Reset the worlds of these indices, or all, each from its seed.

        `scenarios`, one for all of these worlds or one for each, replace their scenarios. Other
        worlds are not changed. ConfigError, before any change, if an argument does not fit.
        """
        seed_of = self.world.seed_of(seeds, worlds)
        indices = [*seed_of]
        if scenarios is not None:
            self.replace_scenarios(_one_each(scenarios, indices), indices)
        self.world.reset(seeds, indices)
        self._begin(seed_of)

    def replace_scenarios(self, scenarios: Sequence[BaseScenario], worlds: Sequence[int]) -> None:
        """Replace scenarios of worlds; ConfigError, before any change, if they do not fit."""
        task.check_fit([self.world.scenarios[w] for w in worlds], scenarios)
        numbers = [
            self.controller.parameters_in(w, scenario)
            for w, scenario in zip(worlds, scenarios, strict=True)
        ]
        self.world.replace_scenarios(worlds, scenarios)
        for w, each in zip(worlds, numbers, strict=True):
            self.controller.write_parameters(w, each)

    def download(self) -> "Loop":
        """Return the loop itself, whose records are on the CPU already."""
        return self

    def step(self) -> None:
        """Run one tick of every world; `exchange` and `situation` then hold the next inputs."""
        self.run(1)

    def run(self, n_ticks: int, modes: Modes | None = None) -> None:
        """Run ticks of every world, in one compiled call unless Python must run between ticks.

        `modes` is SKIP or RUN for each world; by default all run. ConfigError for a command
        that is not finite, or a weight outside [0, 1].
        """
        is_stepped = self.controller.has_rules or not self.world.is_compiled
        at_once = 1 if is_stepped else max(n_ticks, 1)
        chosen = self.world.modes if modes is None else modes
        for _ in range(n_ticks // at_once):
            self.controller.call_rules()
            work = partial(self._advance, at_once, chosen)
            if self.world.is_compiled and self._team.can_poll:
                self._modes[...] = chosen
                arrays = self.world.arrays, self._layers.arrays, self._modes, self.world.errors
                self._team.run(self._serve, arrays, at_once, work)
            else:
                self._on_all_threads(work)
            self.check()

    def snapshot(self) -> Snapshot:
        """Return all that the next ticks depend on; it can be restored any number of times."""
        return Snapshot(self._kind, self.world.snapshot(), self.controller.snapshot())

    def restore(self, snapshot: Snapshot) -> None:
        """Restore a snapshot; the next ticks repeat bit for bit. ConfigError if it does not fit."""
        if snapshot.kind != self._kind:
            raise ConfigError(
                f"the snapshot of {snapshot.kind}: cannot be restored in {self._kind}"
            )
        scenarios = snapshot.world["scenarios"]
        task.check_fit(self.world.scenarios, scenarios)
        before = self.controller.snapshot()
        try:
            self.controller.restore(snapshot.controller)
        except (KeyError, TypeError, ValueError) as error:  # arrays of other shapes or types
            self.controller.restore(before)
            raise ConfigError(
                f"the snapshot of {snapshot.kind}: cannot be restored in this one, whose controller"
                " has other layers or policies; make it with the same controller"
            ) from error
        self.is_blank = False
        self.world.restore(snapshot.world)

    def __getstate__(self) -> dict[str, Any]:
        """Return the arguments that create the loop again, and a snapshot."""
        made_by = self.controllers, self.physics, self.threads
        return {"made_by": made_by, "snapshot": self.snapshot()}

    def __setstate__(self, state: Mapping[str, Any]) -> None:
        """Create the loop from its arguments and restore the snapshot."""
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
        """Copy of each robot's input to the weighting; ConfigError if there is no estimator."""
        return self._estimated("exchange")

    @property
    def situation(self) -> Rows:
        """Copy of the beliefs that the motion of each robot receives; ConfigError as above."""
        return self._estimated("situation")

    def _estimated(self, name: str) -> Rows:
        shown: Rows = copied_rows(estimators_of(self.controller.minds), (name,))
        return shown

    def scene(self, w: int = 0) -> Scene:
        """Return the scene of one world at its current tick; ConfigError if it has no drawing."""
        if self.task.scene is None:
            raise ConfigError(f"the task {self.task.name} has no drawing")
        return self.task.scene(self.world, self.controller.minds, w)

    def _begin(self, seed_of: Mapping[int, int]) -> None:
        """Reset the controller in the worlds of these seeds, then sense and observe in them."""
        self.is_blank = False
        stages = tuple(STAGES) if self.world.is_compiled else AFTER_ENGINE
        for first, last in task.consecutive([*seed_of]):
            self.controller.reset(first, last, [seed_of[w] for w in range(first, last)])
            self._call(stages, 1, self.world.start_modes, first, last)
        self.check()

    def run_stages(self, *stages: str, first: int = 0, last: int | None = None) -> None:
        """Run only these stages (`ticks.STAGES`) of one tick, in the worlds first .. last - 1."""
        end = self.world.n_worlds if last is None else last
        self._call(stages, 1, self.world.modes, first, end)

    def _call(
        self, stages: tuple[str, ...], n_ticks: int, modes: Modes, first: int, last: int
    ) -> None:
        """Run ticks, or only some of their stages, in one compiled call."""
        world, layers = self.world, self._layers
        if stages not in self._kernels:
            self._kernels[stages] = typed_once(self._ticks(stages))
        kernel = self._kernels[stages]
        kernel(world.arrays, layers.arrays, modes, world.errors, first, last, n_ticks)

    def _advance(self, n_ticks: int, modes: Modes, first: int, last: int) -> None:
        """Run ticks of the worlds first .. last - 1 in mode RUN."""
        if self.world.is_compiled:
            self._call(tuple(STAGES), n_ticks, modes, first, last)
            return
        for begin, end in task.consecutive([w for w in range(first, last) if modes[w] == RUN]):
            self.run_stages("decide", first=begin, last=end)
            if not self.world.errors[-1]:
                self.world.move(begin, end)
                self.run_stages(*AFTER_ENGINE, first=begin, last=end)

    @property
    def errors(self) -> Errors:
        """Error code of each world since the last call of `check`."""
        return self.world.errors

    def check(self) -> None:
        """Raise the error of the first world that has one, and clear all errors."""
        if self.world.errors[-1]:
            each = [members_of(controller, self.world.n_robots) for controller in self.controllers]
            raise task.error_in(self.world, lambda w, robot: str(each[w][robot].name))

    @cached_property
    def _serve(self) -> Kernel:
        return typed_once(bind(serve, {"run_chunk": self._ticks(tuple(STAGES))}))

    def _ticks(self, stages: tuple[str, ...]) -> Kernel:
        """Return `run_ticks` of these worlds and layers, with these stages only."""
        functions = {**self.world.functions, **self._layers.functions, **only(*stages)}
        return bind(run_ticks, functions)

    def _on_all_threads(self, work: Callable[[int, int], None]) -> None:
        """Call a function on all worlds, one chunk of them on each thread."""
        self._team.call(work)


AFTER_ENGINE = "tick", "observe"
"""Stages of a tick after an engine in Python."""


def _one_each(values: EachT | Sequence[EachT], worlds: Sequence[int]) -> list[EachT]:
    """Return one value for each world; ConfigError for a list of another length."""
    if not isinstance(values, list | tuple):
        return [cast(EachT, values)] * len(worlds)
    if len(values) != len(worlds):
        raise ConfigError(f"{len(values)} given for {len(worlds)} worlds: must be one for each")
    return list(values)
