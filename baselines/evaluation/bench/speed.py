"""Speed in robot-steps per second: of whole ticks, of bare pymunk, and of the PettingZoo API."""

import statistics
import time
from typing import Any

from baselines.evaluation.bench.bare import bare_pymunk
from baselines.evaluation.bench.cases import CONTROLLER, Case, Tick

REPEATS, LENGTH = 5, 0.5
"""How often a measure is repeated, and about how long each takes [s]; the median counts."""

QUICK_REPEATS, QUICK_LENGTH = 3, 0.15


def seconds_per_tick(tick: Tick, quick: bool) -> float:
    """Median time of one tick [s], over repeats of as many ticks as fill a fixed time."""
    repeats, length = (QUICK_REPEATS, QUICK_LENGTH) if quick else (REPEATS, LENGTH)
    tick()
    count = max(3, round(length / max(_timed(tick, 3), 1e-7)))
    return statistics.median(_timed(tick, count) for _ in range(repeats))


def case_speeds(case: Case, quick: bool) -> dict[str, Any]:
    """Robot-steps per second of a block under both engines, and of bare pymunk."""
    rigid = seconds_per_tick(case.start("rigid", quick).step, quick)
    kinematic = seconds_per_tick(case.start("kinematic", quick).step, quick)
    bare = seconds_per_tick(bare_pymunk(case), quick)
    return {
        "case": case.name,
        "rows": case.rows,
        "rigid": case.rows / rigid,
        "kinematic": case.rows / kinematic,
        "bare_pymunk": case.rows / bare,
        "rigid_over_bare": rigid / bare,
    }


def dictionary_speed(physics: str, quick: bool) -> float:
    """Robot-steps per second of es1 through PettingZoo's dictionaries, actions from outside."""
    from swarm_forage_env import parallel_env

    env: Any = parallel_env("es1", learn="motion", controller=CONTROLLER, physics=physics)
    env.reset(seed=0)
    for number, agent in enumerate(env.possible_agents):
        env.action_space(agent).seed(number)
    actions = [
        {agent: env.action_space(agent).sample() for agent in env.possible_agents}
        for _ in range(16)
    ]
    count = 0

    def step() -> None:
        nonlocal count
        if not env.agents:
            env.reset(seed=count)
        env.step(actions[count // 20 % 16])
        count += 1

    speed = len(env.possible_agents) / seconds_per_tick(step, quick)
    env.close()
    return speed


def _timed(tick: Tick, count: int) -> float:
    """Mean time of so many ticks [s]."""
    start = time.perf_counter()
    for _ in range(count):
        tick()
    return (time.perf_counter() - start) / count
