"""Same seed, same bits: where, and where not. How far machine code and plain Python drift apart."""

import json

import numpy as np
import pytest

from tests.processes import run

pytestmark = pytest.mark.faults

TICKS = 60

WORLDS = {
    ("es1", "ssgiff", "kinematic"): 0.0,
    ("es1", "dsgikf", "rigid"): 0.0,
    ("waypoints-05", "boids-adaptive", "kinematic"): 0.1,
}
"""Scenario, controller and engine, and how far robots may be apart after TICKS [m]: in the last
one, robots that steer by many others make a small difference larger."""

SCRIPT = """
import json, sys
import numpy as np
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.loop import Loop
from swarm_forage_env.scenarios import find_scenario

name, label, engine, seeds = sys.argv[1:]
loop = Loop(find_scenario(name), find_controller(label), json.loads(seeds), engine)
for _ in range(60):
    loop.step()
print(json.dumps(loop.world.robots["pose"].tolist()))
"""


def poses(world, seeds, **variables):
    """Where robots are in the end, in a process of its own."""
    stdout, _ = run("-c", SCRIPT, *world, json.dumps(seeds), variables=variables, timeout=3000)
    return np.array(json.loads(stdout))


@pytest.mark.parametrize("world", WORLDS)
def test_machine_code_and_plain_python_stay_close(world, tries, rng, tell):
    seeds = [rng.randrange(2**32) for _ in range(tries(10))]
    compiled, plain = poses(world, seeds), poses(world, seeds, NUMBA_DISABLE_JIT="1")
    apart = np.linalg.norm((compiled - plain)[..., :2], axis=2)
    assert apart.max() <= WORLDS[world]
    tell(worlds=len(seeds), same=int((apart.max(axis=1) == 0.0).sum()),
         farthest_m=float(apart.max()), failed=0)  # fmt: skip


@pytest.mark.parametrize("world", WORLDS)
def test_two_processes_and_a_cold_cache_give_the_same_bits(world, tries, rng, tell, tmp_path):
    seeds = [rng.randrange(2**32) for _ in range(tries(10))]
    first = poses(world, seeds)
    cold = poses(world, seeds, XDG_CACHE_HOME=str(tmp_path))
    block = poses(world, [1, *seeds, 2])[1:-1]
    for other in (poses(world, seeds), cold, block):
        assert (other == first).all()
    tell(worlds=3 * len(seeds), failed=0)
