"""Pairs of robots that are close, and bodies that are pushed apart."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from swarm_forage_env.kernels.neighbours import EMPTY, find_pairs
from swarm_forage_env.neighbours import Neighbours
from swarm_forage_env.scenario import Arena, Robot, Scenario, Task

ARENA = np.array([1.7, 1.2])


def found(pose, n_robots, reach, arena=ARENA, capacity=1000):
    """Pairs, starts and the number of pairs, found on a grid made for this reach."""
    head = np.full([max(1, int(side / reach)) for side in arena], EMPTY, np.int32)
    pairs = np.full((capacity, 2), -7, np.int32)
    start = np.zeros(len(pose) // n_robots + 1, np.int64)
    n_pairs = find_pairs(
        pose, n_robots, arena, reach, head, np.zeros(n_robots, np.int32), pairs, start
    )
    assert np.all(head == EMPTY)
    return pairs, start, n_pairs


def close_pairs(pose, n_robots, reach):
    """The same by comparing everyone with everyone of the same world."""
    return {
        (i, j)
        for i in range(len(pose))
        for j in range(i)
        if i // n_robots == j // n_robots and np.hypot(*(pose[i, :2] - pose[j, :2])) < reach
    }


def as_set(pairs):
    return {tuple(pair) for pair in pairs.tolist()}


@given(
    st.integers(1, 3).flatmap(
        lambda worlds: st.integers(1, 12).flatmap(
            lambda robots: st.tuples(
                st.just(robots),
                arrays(np.float64, (worlds * robots, 3), elements=st.floats(-1.0, 1.0)),
            )
        )
    ),
    st.floats(0.05, 3.0),
)
def test_the_grid_finds_the_pairs_that_comparing_everyone_finds(swarm, reach):
    n_robots, pose = swarm  # some lie outside the walls: the outermost cells hold them
    pairs, start, n_pairs = found(pose, n_robots, reach)
    assert as_set(pairs[:n_pairs]) == close_pairs(pose, n_robots, reach)
    assert len(as_set(pairs[:n_pairs])) == n_pairs
    for world in range(len(start) - 1):
        block = pairs[start[world] : start[world + 1]]
        assert np.all(block // n_robots == world)


def test_the_pairs_of_a_world_are_the_same_in_the_same_order_in_a_block():
    pose = np.random.default_rng(1).uniform(-0.5, 0.5, (60, 3))
    pairs, start, _ = found(pose, 20, 0.2)
    for world in range(3):
        alone, _, n_pairs = found(pose[20 * world : 20 * world + 20], 20, 0.2)
        block = pairs[start[world] : start[world + 1]]
        np.testing.assert_array_equal(block, alone[:n_pairs] + 20 * world)


def test_too_little_room_is_told_and_never_exceeded():
    pose = np.zeros((10, 3))
    pairs, _, n_pairs = found(pose, 10, 0.2, capacity=5)
    assert n_pairs == 45
    assert len(as_set(pairs)) == 5


def test_neighbours_make_room_for_a_clump():
    scenario = Scenario()
    neighbours = Neighbours(scenario, 2, 0.15)
    neighbours.find(np.zeros((20, 3)))
    assert neighbours.n_pairs == 90
    assert neighbours.start.tolist() == [0, 45, 90]
    assert as_set(neighbours.pairs[:90]) == close_pairs(np.zeros((20, 3)), 10, 0.15)


def test_an_arena_smaller_than_the_reach_is_one_cell():
    scenario = Scenario(
        arena=Arena(length=0.1, width=0.1),
        robot=Robot(radius=0.01),
        task=Task(n_robots=2, area_radius=0.01, area_distance=0.06, start_radius=0.02),
    )
    neighbours = Neighbours(scenario, 1, 0.15)
    neighbours.find(np.array([[-0.04, -0.04, 0.0], [0.04, 0.04, 0.0]]))
    assert neighbours.n_pairs == 1


@pytest.mark.parametrize(("distance", "n_pairs"), [(0.2 - 1e-9, 1), (0.2, 0), (0.2 + 1e-9, 0)])
def test_a_pair_is_closer_than_the_reach(distance, n_pairs):
    pose = np.array([[0.0, 0.0, 0.0], [distance, 0.0, 0.0]])
    assert found(pose, 2, 0.2)[2] == n_pairs
