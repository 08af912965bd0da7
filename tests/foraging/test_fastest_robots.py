"""At the highest speed that is allowed no robot drives through another."""

import numpy as np
import pytest
from scipy.spatial.distance import pdist

from swarm_forage_env.controllers import find_controller
from swarm_forage_env.epuck.scenario import MAX_STEP
from swarm_forage_env.loop import Loop
from swarm_forage_env.scenarios import find_scenario

WIDEST_OVERLAP = 0.001
"""Of two bodies after a tick [m]."""


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("engine", ["kinematic", "rigid"])
def test_the_fastest_robots_of_every_world_neither_overlap_nor_leave_it(engine, seed):
    rng = np.random.default_rng(seed)
    radius = rng.uniform(0.02, 0.1)
    limit = MAX_STEP * radius / 0.1
    scenario = find_scenario(
        "es1",
        {"radius": radius, "max_speed": limit, "cruise_speed": limit, "start_radius": 0.2,
         "n_robots": 4, "length": 0.9, "width": 0.6, "area_radius": 0.01, "area_distance": 0.45},
    )  # fmt: skip
    loop = Loop(scenario, find_controller("nc"), [seed, seed + 10, seed + 20], engine)
    robots = loop.world.robots
    robots["action"]["motion"] = 1
    widest = 0.0
    for _ in range(400):
        robots["action"]["wheels"] = rng.uniform(-0.2, 1.0, robots["action"]["wheels"].shape)
        loop.step()
        for places in robots["pose"][:, :, :2]:
            widest = max(widest, 2 * radius - pdist(places).min())
            assert (np.abs(places) <= [0.45 - radius + 1e-9, 0.3 - radius + 1e-9]).all()
    assert widest < WIDEST_OVERLAP


def test_robots_that_others_push_at_each_other_do_not_overlap():
    scenario = find_scenario(
        "es1",
        {"radius": 2.9, "axle": 53.0, "max_speed": 0.129, "cruise_speed": 0.129, "tick": 3.5,
         "start_radius": 14.5, "n_robots": 5, "length": 39.0, "width": 35.0, "area_radius": 0.5,
         "area_distance": 31.0},
    )  # fmt: skip
    loop = Loop(scenario, find_controller("nc"), [6, 8, 9], "kinematic")
    for _ in range(115):
        loop.step()
        nearest = min(pdist(places).min() for places in loop.world.robots["pose"][:, :, :2])
        assert 2 * 2.9 - nearest < WIDEST_OVERLAP
