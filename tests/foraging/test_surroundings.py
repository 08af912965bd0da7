"""Neighbours of a robot, and contacts of many bodies, also at the highest speed."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.distance import pdist

from swarm_forage_env.controllers import find_controller
from swarm_forage_env.epuck.scenario import MAX_STEP
from swarm_forage_env.epuck.surroundings import COUNT, FIRST
from swarm_forage_env.epuck.world import max_neighbours
from swarm_forage_env.equations.contacts import OVERLAP
from swarm_forage_env.equations.neighbours import EMPTY
from swarm_forage_env.foraging.world import ForagingWorld
from swarm_forage_env.loop import Loop
from swarm_forage_env.scenarios import find_scenario

RADIUS = 0.035
WALLS = np.array([0.815, 0.565])
"""Farthest places of a centre inside the walls."""


def lists_of(block):
    """The neighbours of each robot of the first world, in order."""
    return [row[FIRST : FIRST + row[COUNT]].tolist() for row in block.near[0]]


def close_to(places, i, reach):
    """The same by comparing with everyone."""
    away = np.hypot(*(places[:, :2] - places[i, :2]).T)
    return {j for j in range(len(places)) if j != i and away[j] < reach}


@given(
    st.integers(1, 12).flatmap(
        lambda robots: arrays(np.float64, (robots, 3), elements=st.floats(-1.0, 1.0))
    ),
    st.floats(0.05, 3.0),
)
def test_the_grid_finds_the_neighbours_that_comparing_everyone_finds(block, places, reach):
    robots = block(places, reach=reach)  # some lie outside the walls: the outermost cells hold them
    most = robots.look_around()
    lists = lists_of(robots)
    for i, found in enumerate(lists):
        assert set(found) == close_to(places, i, reach)
        assert len(set(found)) == len(found)
        assert [j > i for j in found] == sorted(j > i for j in found)  # lower numbers come first
    assert most == max(map(len, lists))
    assert np.all(robots.cells == EMPTY)
    robots.near[...] = -7
    assert robots.look_around_each() == most
    assert lists_of(robots) == lists


def test_too_little_room_is_told_and_never_exceeded(block):
    robots = block(np.zeros((10, 3)))
    robots.near = np.full((1, 10, FIRST + 5), -7, np.int32)
    assert robots.look_around_each() == robots.look_around() == 9
    for i, row in enumerate(robots.near[0]):
        assert row[COUNT] == 5
        assert len({*row[FIRST:].tolist()} - {i, -7}) == 5


@pytest.mark.parametrize("physics", ["rigid", "kinematic"])
def test_more_robots_in_one_place_than_there_is_room_for_are_refused(physics):
    scenario = find_scenario("es3")
    assert max_neighbours(scenario) < scenario.task.n_robots - 1
    world = ForagingWorld([scenario, scenario], [0, 1], physics)
    world.robots["pose"][1] = 0.0
    with pytest.raises(RuntimeError, match="has 99 neighbours"):
        world.sense_first()
    with pytest.raises(RuntimeError, match="neighbours, more than discs"):
        world.tick(0, 2)


@pytest.mark.parametrize(("distance", "most"), [(0.2 - 1e-9, 1), (0.2, 0), (0.2 + 1e-9, 0)])
def test_a_neighbour_is_closer_than_the_reach(block, distance, most):
    robots = block([(0.0, 0.0, 0.0), (distance, 0.0, 0.0)], reach=0.2)
    assert robots.look_around() == most


# --- contacts ------------------------------------------------------------------------------------


@pytest.fixture(scope="session")
def settled(block):
    """Where robots put at these places come to lie, and the block of them."""

    def settle(places, reach=3.0):
        robots = block(np.column_stack([places, np.full(len(places), 0.5)]), reach=reach)
        assert robots.settle()
        assert np.all(robots.state.pose[:, 2] == 0.5)
        return robots.state.pose[:, :2], robots

    return settle


@given(st.integers(0, 10_000), st.integers(2, 30), st.floats(0.05, 0.2))
def test_a_clump_anywhere_is_dissolved(settled, seed, n_robots, size):
    rng = np.random.default_rng(seed)
    middle = rng.uniform([-0.9, -0.6], [0.9, 0.6])
    places, _ = settled(middle + rng.uniform(-size, size, (n_robots, 2)))
    assert 2.0 * RADIUS - pdist(places).min() <= OVERLAP + 1e-9
    assert np.all(np.abs(places) <= WALLS)


def test_what_a_sensor_can_reach_after_settling_is_among_the_neighbours(settled):
    rng = np.random.default_rng(5)
    lattice = [(2 * i + j % 2, np.sqrt(3.0) * j) for i in range(5) for j in range(5)]
    clump = RADIUS * np.array(lattice) - 0.15
    for _ in range(20):
        places, robots = settled(clump + rng.uniform(-0.006, 0.006, clump.shape), reach=0.17)
        for i, listed in enumerate(lists_of(robots)):
            assert close_to(places, i, 0.15) <= set(listed)


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
