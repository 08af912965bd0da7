"""Benchmark cases: the worlds that are timed, and their warm-up."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from baselines.evaluation.experiment_config import find_recipe
from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.loop import ControlLoop
from swarm_forage_env.scenario import Scenario
from swarm_forage_env.scenarios import find_foraging

CONTROLLER = "ssgikf"


@dataclass(frozen=True)
class Case:
    """A benchmark case: a block of worlds whose ticks are timed."""

    name: str
    scenario: Scenario
    n_worlds: int = 1
    is_spread: bool = False
    """Robots are placed all over the arena, not in the start circle."""
    warm_up: int = 3000
    """Ticks before the clock starts, in which robots spread, find the areas and talk."""

    @property
    def rows(self) -> int:
        """Number of robots in the block."""
        return self.n_worlds * self.scenario.task.n_robots

    def start(self, physics: str, quick: bool) -> ControlLoop:
        """Run the warm-up and return the loop whose ticks are timed."""
        loop = ControlLoop(self.scenario, find_recipe(CONTROLLER), range(self.n_worlds), physics)
        if self.is_spread:
            loop.world.state.pose[:] = uniform_poses(self.scenario, self.n_worlds)
        for _ in range(self.warm_up // 5 if quick else self.warm_up):
            loop.step()
        return loop


def all_cases() -> list[Case]:
    """All benchmark cases: the scenarios of the budgets, and es3 at 1, 10 and 100 times its size.

    A large swarm would take hours to leave its start circle: the last three start all over
    the arena, and warm up for 300 ticks.
    """
    es1, es3 = find_foraging("es1"), find_foraging("es3")
    spread = [
        Case(name, enlarged(es3, factor), is_spread=True, warm_up=300)
        for name, factor in (("es3 spread", 1), ("es3 x 10", 10), ("es3 x 100", 100))
    ]
    return [
        Case("es1", es1),
        Case("es1 x 30", es1, n_worlds=30),
        Case("es2", find_foraging("es2")),
        Case("es3", es3),
        *spread,
    ]


def enlarged(scenario: Scenario, factor: int) -> Scenario:
    """A scenario with `factor` times the robots at the same density: every length grows."""
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
    return find_foraging(scenario, {**lengths, **robots})


def uniform_poses(scenario: Scenario, n_worlds: int) -> Float64[Array, "rows 3"]:
    """Random poses of robots all over the arena, none touching another."""
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
    return pose.reshape(-1, 3)


Tick = Callable[[], object]
"""Something that is timed: one tick of a block."""
