"""Neighbours of a robot, and contacts of many bodies."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.distance import pdist

from swarm_forage_env.epuck.surroundings import COUNT, FIRST
from swarm_forage_env.epuck.world import max_neighbours
from swarm_forage_env.equations.contacts import OVERLAP
from swarm_forage_env.equations.neighbours import EMPTY
from swarm_forage_env.foraging.world import ForagingWorld
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
