"""Benchmark cases: the timed worlds, the interface that steps them, and their warm-up."""

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import partial
from itertools import count, cycle, islice
from typing import Any

import numpy as np

from baselines.evaluation.episode import run_episodes
from baselines.evaluation.experiment_config import find_layered_controller
from swarm_forage_env.arrays import Array, Float32, Float64
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.loop import Loop
from swarm_forage_env.scenarios import find_scenario

CONTROLLER = "ssgikf"

HELD = 20  # ticks for which a random action is held, so that robots move around

Tick = Callable[[], object]  # a timed call: one or several ticks of a block
Tell = Callable[[str], None]  # receives the name of each measurement before it starts
Measured = dict[str, Any]  # measurements by name, as JSON values


@dataclass(frozen=True)
class Case:
    """A benchmark case: a block of worlds whose ticks are timed."""

    name: str
    scenario: Scenario
    n_worlds: int = 1
    is_spread: bool = False  # robots are placed all over the arena, not in the start circle
    warm_up: int = 3000
    """Ticks before the timing, in which robots spread, find the areas and exchange messages."""
    n_ticks: int = 1  # ticks of a timed call

    @property
    def rows(self) -> int:
        """Number of robots in the block."""
        return self.n_worlds * self.scenario.task.n_robots

    def tick(self, physics: str, quick: bool, threads: int = 1) -> Tick:
        """Run the warm-up and return the timed call."""
        return partial(self.start(physics, quick, threads).run, self.n_ticks)

    def start(self, physics: str, quick: bool, threads: int = 1) -> Loop:
        """Run the warm-up and return the loop whose ticks are timed."""
        controller = find_layered_controller(CONTROLLER)
        loop = Loop(self.scenario, controller, range(self.n_worlds), physics, threads)
        if self.is_spread:
            loop.world.robots["pose"] = uniform_poses(self.scenario, self.n_worlds)
            loop.world.sense_first()
        loop.run(self.n_warm_up(quick))
        return loop

    def n_warm_up(self, quick: bool) -> int:
        """Return the number of warm-up ticks; a quick run has a fifth of them."""
        return self.warm_up // 5 if quick else self.warm_up

    def _driven(
        self,
        reset: Callable[..., object],
        step: Callable[[Any], object],
        actions: Iterable[object],
        quick: bool,
    ) -> Tick:
        """Run the warm-up and return the call of one step; each action is held for `HELD` steps."""

        def steps() -> Iterator[None]:
            held = (action for action in cycle(actions) for _ in range(HELD))
            for seed in count():
                reset(seed=seed)
                for action in islice(held, self.scenario.n_ticks):
                    step(action)
                    yield

        running = steps()
        for _ in range(self.n_warm_up(quick)):
            next(running)
        return partial(next, running)


class _EpisodeCase(Case):
    """Case of whole episodes: worlds are created, run and measured."""

    def tick(self, physics: str, quick: bool, threads: int = 1) -> Tick:
        duration = {"task.duration": self.n_ticks * self.scenario.tick}
        scenario = find_scenario(self.scenario, duration)
        controller = find_layered_controller(CONTROLLER)
        return partial(run_episodes, scenario, controller, range(self.n_worlds), physics, threads)


class _ArrayCase(Case):
    """Case in which random actions drive the robots through the array environment."""

    def tick(self, physics: str, quick: bool, threads: int = 1) -> Tick:
        from swarm_forage_env import ArrayEnv
        from swarm_forage_env.envs.keywords import OwnName

        env = ArrayEnv(
            self.scenario, self.n_worlds, CONTROLLER,
            physics=OwnName(physics), threads=threads, decision_period=1,
        )  # fmt: skip
        wheels = random_wheels(self.rows).reshape(-1, self.n_worlds, len(env.learners), 2)
        return self._driven(env.reset, env.step, wheels, quick)


class _DictionaryCase(Case):
    """Case in which random actions drive the robots through PettingZoo's dictionaries."""

    def tick(self, physics: str, quick: bool, threads: int = 1) -> Tick:
        from swarm_forage_env import parallel_env
        from swarm_forage_env.envs.keywords import OwnName

        engine = OwnName(physics)
        env = parallel_env(self.scenario, controller=CONTROLLER, physics=engine, decision_period=1)
        agents = env.possible_agents
        wheels = [dict(zip(agents, each, strict=True)) for each in random_wheels(len(agents))]
        return self._driven(env.reset, env.step, wheels, quick)


def random_wheels(rows: int) -> Float32[Array, "actions rows 2"]:
    """Draw 16 random actions for all robots: wheel speeds in [-1, 1]."""
    return np.random.default_rng(2).uniform(-1.0, 1.0, (16, rows, 2)).astype(np.float32)


def all_cases() -> list[Case]:
    """Return all benchmark cases; the last three are es3 at 1, 10 and 100 times its size.

    A large swarm would need hours to leave its start circle, so the robots of the last three start
    all over the arena and warm up for 300 ticks.
    """
    es1, es3 = find_scenario("es1"), find_scenario("es3")
    spread = {"es3 spread": 1, "es3 x 10": 10, "es3 x 100": 100}
    return [
        Case("es1", es1),
        Case("es1 x 30", es1, n_worlds=30),
        Case("es1 x 64", es1, n_worlds=64),
        Case("es1, ten ticks a call", es1, n_ticks=10),
        _EpisodeCase("es1 x 30, episodes", es1, n_worlds=30, n_ticks=3000),
        _ArrayCase("es1 x 64, arrays", es1, n_worlds=64),
        _DictionaryCase("es1, dicts", es1),
        Case("es2", find_scenario("es2")),
        Case("es3", es3),
        *(Case(name, enlarged(es3, k), is_spread=True, warm_up=300) for name, k in spread.items()),
    ]


def enlarged(scenario: Scenario, factor: int) -> Scenario:
    """Return the scenario with `factor` times the robots at the same density, in a larger arena."""
    side = math.sqrt(factor)
    task, arena, radius = scenario.task, scenario.arena, scenario.robot.radius
    lengths = {
        "arena.length": side * arena.length,
        "arena.width": side * arena.width,
        "task.area_radius": side * task.area_radius,
        "task.area_distance": side * task.area_distance,
        "task.start_radius": side * (task.start_radius + radius) - radius,
    }
    name = f"{scenario.name} x {factor}"
    robots = {"name": name, "task.n_robots": factor * task.n_robots}
    larger: Scenario = find_scenario(scenario, lengths | robots)
    return larger


def uniform_poses(scenario: Scenario, n_worlds: int) -> Float64[Array, "worlds robots 3"]:
    """Draw random poses of robots all over the arena, without contacts between robots."""
    rng = np.random.default_rng(0)
    arena, n_robots = scenario.arena, scenario.task.n_robots
    columns = math.ceil(math.sqrt(n_robots * arena.length / arena.width))
    field = np.array([arena.length / columns, arena.width / math.ceil(n_robots / columns)])
    free = np.maximum(field - 2.0 * scenario.robot.radius, 0.0)
    place = np.arange(n_robots)
    corner = np.stack([place % columns, place // columns], axis=1) + 0.5
    middle = corner * field - 0.5 * np.array([arena.length, arena.width])
    pose = np.empty((n_worlds, n_robots, 3))
    pose[..., :2] = middle + free * rng.uniform(-0.5, 0.5, (n_worlds, n_robots, 2))
    pose[..., 2] = rng.uniform(-math.pi, math.pi, (n_worlds, n_robots))
    return pose
