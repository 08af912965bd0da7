"""Millions of ticks with flat memory, and many threads at once with the same bits."""

import gc
import os
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from swarm_forage_env.controllers import find_controller
from swarm_forage_env.loop import Loop
from swarm_forage_env.scenarios import find_scenario

pytestmark = pytest.mark.faults

LONG = {
    ("es1", "ssgikf", "kinematic"): 80_000,
    ("es1", "ssgiff", "rigid"): 10_000,
    ("waypoints-05", "boids-adaptive", "kinematic"): 10_000,
}
"""Scenario, controller and engine, and ticks for each of FAULTS: ten million where it is 100."""

GROWTH = 1.0
"""By which memory may grow [MB]."""


def resident():
    """Memory that this process has now [MB]."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="reads /proc")
@pytest.mark.parametrize(("name", "controller", "engine"), LONG)
def test_memory_is_flat_over_many_ticks(name, controller, engine, tries, tell):
    ticks = tries(100 * LONG[name, controller, engine])
    loop = Loop(find_scenario(name), find_controller(controller), [0], engine)
    for _ in range(max(ticks // 10, 1000)):
        loop.step()
    gc.collect()
    before = resident()
    for tick in range(ticks):
        if tick % loop.world.scenario.n_ticks == 0:
            loop.reset([tick])
        loop.step()
    gc.collect()
    growth = resident() - before
    assert np.isfinite(loop.world.robots["pose"]).all()
    assert growth < GROWTH
    tell(ticks=ticks, growth_MB=round(growth, 2), failed=0)


def bits(label, engine, seeds, threads, ticks=100):
    """What is true after some ticks."""
    loop = Loop(find_scenario("es1"), find_controller(label), seeds, engine, threads)
    for _ in range(ticks):
        loop.step()
    return loop.world.robots.tobytes(), loop.controller.minds.tobytes()


def test_many_threads_at_once_give_the_same_bits(tries, rng, tell):
    labels = ("nc", "ssgikf", "ssgiff", "dsgikf", "dsgiff")
    jobs = [
        (rng.choice(labels), rng.choice(["kinematic", "rigid"]),
         tuple(rng.sample(range(1000), rng.randint(1, 5))), rng.randint(1, 4))
        for _ in range(tries(100))
    ]  # fmt: skip
    alone = [bits(label, engine, seeds, 1) for label, engine, seeds, _ in jobs]
    with ThreadPoolExecutor(16) as pool:
        together = list(pool.map(lambda job: bits(*job), jobs))
    assert together == alone
    tell(tried=len(jobs), failed=0)
