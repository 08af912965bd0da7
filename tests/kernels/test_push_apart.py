"""Contacts that the engine left: bodies are pushed apart and back inside the walls."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from swarm_forage_env.neighbours import Neighbours
from swarm_forage_env.scenarios import find_scenario
from swarm_forage_env.world import World

RADIUS = 0.035
WALLS = np.array([0.815, 0.565])
"""Farthest places of a centre inside the walls."""


def settle(*worlds, reach=3.0):
    """Worlds of es1's robots put at given places, and settled."""
    n_robots = len(worlds[0])
    scenario = find_scenario("es1", {"n_robots": n_robots, "start_radius": 0.3})
    world = World(scenario, range(len(worlds)), "kinematic")
    world.neighbours = Neighbours(scenario, len(worlds), reach)
    world.state.pose[:, :2] = np.concatenate(worlds)
    world.state.pose[:, 2] = 0.5
    world._settle()
    return world


def worst_overlap(pose):
    d = np.hypot(*(pose[:, None, :2] - pose[None, :, :2]).transpose(2, 0, 1))
    np.fill_diagonal(d, np.inf)
    return 2.0 * RADIUS - d.min()


def test_two_discs_part_along_the_line_between_them_each_by_half():
    world = settle([(0.0, 0.0), (0.03, 0.04)])
    pose = world.state.pose
    np.testing.assert_allclose(pose[:, :2], [[-0.006, -0.008], [0.036, 0.048]], atol=1e-12)
    assert np.all(pose[:, 2] == 0.5)
    assert world._settled.all()


def test_two_discs_in_one_place_part_along_the_long_side():
    pose = settle([(0.1, 0.1), (0.1, 0.1)]).state.pose
    np.testing.assert_allclose(np.sort(pose[:, 0]), [0.065, 0.135], atol=1e-12)
    np.testing.assert_allclose(pose[:, 1], 0.1, atol=1e-12)


@pytest.mark.parametrize("x", [-0.9, -0.815, 0.815, 0.9])
@pytest.mark.parametrize("y", [-0.7, -0.565, 0.565, 0.7])
def test_a_disc_in_or_beyond_a_wall_is_put_back_inside(x, y):
    pose = settle([(x, y)]).state.pose
    np.testing.assert_allclose(pose[0, :2], [np.copysign(0.815, x), np.copysign(0.565, y)])


def test_two_discs_at_a_wall_both_end_inside_and_apart():
    pose = settle([(0.84, 0.0), (0.80, 0.0)]).state.pose
    assert np.abs(pose[:, 0]).max() <= 0.815
    assert worst_overlap(pose) < 1e-3


def test_two_discs_in_a_corner_both_end_inside_and_apart():
    pose = settle([(0.815, 0.565), (0.815, 0.565)]).state.pose
    assert np.abs(pose[:, 0]).max() <= 0.815
    assert np.abs(pose[:, 1]).max() <= 0.565
    assert worst_overlap(pose) < 1e-3


@given(st.integers(0, 10_000), st.integers(2, 30), st.floats(0.05, 0.2))
def test_a_clump_anywhere_is_dissolved(seed, n_robots, size):
    rng = np.random.default_rng(seed)
    middle = rng.uniform([-0.9, -0.6], [0.9, 0.6])
    world = settle(middle + rng.uniform(-size, size, (n_robots, 2)))
    assert worst_overlap(world.state.pose) < 1e-3
    assert np.all(np.abs(world.state.pose[:, :2]) <= WALLS)
    assert world._settled.all()


def test_worlds_without_contact_are_not_touched():
    rng = np.random.default_rng(3)
    apart = np.stack(np.meshgrid(np.linspace(-0.5, 0.5, 5), [-0.2, 0.2]), -1).reshape(-1, 2)
    apart = apart + rng.uniform(-0.01, 0.01, apart.shape)
    clump = rng.uniform(-0.05, 0.05, apart.shape)
    world = settle(apart, clump, apart)
    assert np.array_equal(world.state.pose[:10, :2], apart)
    assert np.array_equal(world.state.pose[20:, :2], apart)
    assert not np.array_equal(world.state.pose[10:20, :2], clump)


def test_an_overlap_within_the_tolerance_stays_settle():
    world = settle([(0.0, 0.0), (0.06995, 0.0)])
    assert world._settled.all()


def test_what_a_sensor_can_reach_after_settling_is_among_the_pairs():
    rng = np.random.default_rng(5)
    places = [(2 * i + j % 2, np.sqrt(3.0) * j) for i in range(5) for j in range(5)]
    clump = RADIUS * np.array(places) - 0.15
    for _ in range(20):
        world = settle(clump + rng.uniform(-0.006, 0.006, clump.shape), reach=0.15)
        pairs = world.neighbours.pairs[: world.neighbours.n_pairs]
        d = np.hypot(*(world.state.pose[:, None, :2] - world.state.pose[None, :, :2]).T)
        i, j = np.nonzero(np.tril(d < 0.15, -1))
        assert set(zip(i.tolist(), j.tolist(), strict=True)) <= {tuple(p) for p in pairs.tolist()}
