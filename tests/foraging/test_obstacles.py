"""Worlds with obstacles: robots touch them, see them, and may be hidden behind them."""

import math

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from swarm_forage_env.envs.array_env import ArrayEnv
from swarm_forage_env.foraging.arenas import SHAPES, mg1
from swarm_forage_env.loop import Loop
from swarm_forage_env.registry import CONTROLLERS
from swarm_forage_env.scenarios import find_scenario
from tests.scenario.test_overrides import check_refused

RADIUS = 0.035
UPRIGHT = (0.3, -0.5, 0.3, 0.5, 0.0)
WALL = {"points": [[0.3, -0.4], [0.3, 0.4]], "radius": 0.01}
DISC = {"points": [[0.0, 0.4]], "radius": 0.1}
AREAS = [
    {"kind": "nest", "centre": [-0.7, 0.0]},
    {"centre": [0.7, 0.3], "moves_at": 1.0, "moves_to": [0.7, -0.3]},
]
"""The second moves onto an obstacle."""


def es1_with(*obstacles, **more):
    return find_scenario("es1", {"obstacles": list(obstacles), **more})


@pytest.mark.parametrize("heading", [0.0, 0.4, -1.3, math.pi])
@pytest.mark.parametrize("gap", [0.001, 0.02, 0.049, 0.0501])
def test_a_wall_inside_is_seen_as_the_outer_wall_is(block, heading, gap):
    outer = block([(0.85 - RADIUS - gap, 0.0, heading)], proximity_noise=0.0)
    inner = block([(0.3 - RADIUS - gap, 0.0, heading)], proximity_noise=0.0, obstacles=[UPRIGHT])
    seen = inner.sense().proximity
    assert seen == pytest.approx(outer.sense().proximity, abs=1e-5)
    assert np.any(seen > 0.0) or gap > 0.04


@pytest.mark.parametrize(("is_shadowed", "heard"), [(False, 3), (True, 1)])
def test_robots_behind_an_obstacle_are_heard_only_where_the_radio_is_not_shadowed(
    block, is_shadowed, heard
):
    places = [(0.25, 0.0, 0.0), (0.35, 0.0, 0.0), (0.35, 0.05, 0.0), (0.25, 0.05, 0.0)]
    robots = block(
        places, obstacles=[UPRIGHT], is_shadowed=is_shadowed, loss_near=0.0, loss_far=0.0
    )
    found, slots = robots.receive()
    assert_array_equal(found.n, heard)
    if is_shadowed:
        assert_array_equal(found.sender[slots], [3, 2, 1, 0])


def test_touching_an_obstacle_is_an_event():
    env = ArrayEnv(es1_with(WALL, n_robots=1), reward=lambda before, after, e: e["contact"] * 1.0)
    env.reset(seed=0)
    for x, touched in ((0.3 - 0.01 - RADIUS - 0.0005, True), (0.2, False)):
        env.world.robots["pose"][0, 0] = x, 0.0, 0.0
        reward = env.step(np.array([[[-1.0, 0.0]]], np.float32))[1]
        assert bool(reward[0, 0] > 0) == touched


def test_numbers_are_randomised_beside_obstacles():
    env = ArrayEnv(es1_with(DISC), n_worlds=3, randomise={"task.area_distance": (1.0, 1.4)})
    env.reset(seed=0)
    assert env.world.worlds["n_obstacles"].tolist() == [1, 1, 1]
    env.reset(seed=0, options={"obstacles": [DISC, WALL]})
    assert env.world.worlds["n_obstacles"].tolist() == [2, 2, 2]


@pytest.mark.parametrize("shape", SHAPES)
def test_the_arenas_of_mg1_have_none_to_four_obstacles_and_are_foraged_in(shape):
    assert [len(mg1(shape, n).obstacles) for n in range(5)] == [*range(5)]
    loop = Loop(mg1(shape, 3), CONTROLLERS["ssgikf"], [0], "kinematic")
    loop.run(3000)
    assert loop.world.state.round_trips.sum() > 0


@pytest.mark.parametrize(
    ("overrides", "parts"),
    [
        ({"obstacles": [{"points": [[0.1, 0.1]], "radius": 0.05}]}, ["start circle", "[0]"]),
        ({"obstacles": [DISC, {"points": [[0.75, 0.3], [0.75, -0.3]]}]}, ["prey area", "[1]"]),
        ({"obstacles": [{"points": [[-0.75, 0.0]], "radius": 0.01}]}, ["nest", "(-0.75, 0)"]),
        (
            {"obstacles": [{"points": [[-0.4, -0.4], [0.4, -0.4], [0, 0.5]], "is_closed": True}]},
            ["start circle", "overlaps"],
        ),
        ({"obstacles": "wall"}, ["obstacles=wall: must be a list in JSON, such as "]),
        ({"obstacles": [{"points": [[0.4, 0.4]]}]}, ["single point", "radius above 0"]),
        ({"obstacles": [{"points": [[0.4, 0.4], [0.5, 0.4]], "is_closed": True}]}, ["at least 3"]),
        ({"obstacles": [{"points": []}]}, ["obstacles.0.points", "at least 1"]),
        ({"obstacles": [{"points": [[0.4, math.nan]]}]}, ["obstacles.0.points", "finite"]),
        ({"obstacles": [{"points": [[0.4, 0.4]], "radios": 1.0}]}, ["obstacles.0.radios"]),
        ({"arena.corners": [(0.0, 0.0), (1.0, 0.0)]}, ["arena.corners", "at least 3"]),
        ({"arena.corners": [(0.0, 0.0), (1.0, 0.0), (0.0, 0.5)]}, ["(1, 0)", "arena.length"]),
        ({"arena.corners": [(-0.8, -0.5), (0.8, -0.5), (0.8, 0.3)]}, ["outside of arena.corners"]),
        (
            {"arena.corners": [(-0.8, -0.6), (0.8, -0.6), (0.8, 0.6), (-0.8, 0.6)]},
            ["nest", "along arena.corners"],
        ),
        ({"obstacles": [DISC], "robot.max_speed": 0.2}, ["robot.max_speed=0.2", "0.175"]),
        (
            {"task.areas": AREAS, "obstacles": [{"points": [[0.7, -0.45]], "radius": 0.1}]},
            ["prey area about (0.7, -0.3)", "obstacles[0]"],
        ),
    ],
)
def test_what_stands_in_the_way_is_refused_in_one_line(overrides, parts):
    check_refused("es1", overrides, parts)
