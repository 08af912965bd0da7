"""Worlds with several areas of a kind, of differing worth, or that move."""

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from swarm_forage_env.arrays import NEST, PREY
from swarm_forage_env.foraging.metrics import nearest_areas
from swarm_forage_env.foraging.world import ForagingWorld
from swarm_forage_env.loop import Loop
from swarm_forage_env.registry import CONTROLLERS
from swarm_forage_env.scenarios import find_scenario
from tests.commands import parallel_env
from tests.scenario.test_overrides import check_refused

NEST_AREA = {"kind": "nest", "centre": [-0.7, 0.0]}
SECOND_NEST = {"kind": "nest", "centre": [-0.5, 0.4], "worth": 2.0}
POOR = {"kind": "prey", "centre": [0.7, 0.0], "worth": 0.5}
RICH = {"kind": "prey", "centre": [0.5, 0.4], "worth": 3.0}
MOVING = {"kind": "prey", "centre": [0.7, 0.3], "moves_at": 1.0, "moves_to": [0.7, -0.3]}


def es1_with(*areas, **more):
    return find_scenario("es1", {"task.areas": list(areas), **more})


def test_the_pair_written_out_is_the_default_bit_for_bit(bits):
    pair = [{"kind": "prey", "centre": [0.75, 0.0]}, {"kind": "nest", "centre": [-0.75, 0.0]}]
    loops = [
        Loop(scenario, CONTROLLERS["ssgiff"], [0, 1], "kinematic")
        for scenario in (find_scenario("es1"), es1_with(*pair))
    ]
    for loop in loops:
        loop.run(600)
    assert bits(loops[0]) == bits(loops[1])
    assert es1_with(SECOND_NEST, RICH).false_place_distance == 0.5  # half their distance


def visit(world, go, place):
    """The only robot stands on a place for a tick; its reward."""
    world.state.pose[:] = [place[0] - 0.03, place[1], 0.0]
    go(world)
    return float(world.state.reward[0])


@pytest.fixture
def alone():
    def start(*areas):
        return ForagingWorld([es1_with(*areas, n_robots=1)], [0], "kinematic")

    return start


def test_a_trip_pays_what_prey_area_and_nest_are_worth_and_counts_as_one(alone, go):
    world = alone(NEST_AREA, SECOND_NEST, POOR, RICH)
    nest, second, poor, rich = (a["centre"] for a in (NEST_AREA, SECOND_NEST, POOR, RICH))
    assert visit(world, go, nest) == 0.0
    assert visit(world, go, rich) == 0.0
    assert visit(world, go, poor) == 0.0  # it carries an item already
    assert visit(world, go, nest) == 3.0
    assert visit(world, go, second) == 0.0
    assert visit(world, go, poor) == 0.0
    assert visit(world, go, second) == 1.0  # 0.5 from the poor one, times 2
    assert world.state.round_trips.tolist() == [2]
    assert world.state.first_visit[0].tolist() == [1, 2]


def test_an_area_moves_once_and_is_back_at_the_next_start(alone, go):
    world = alone(NEST_AREA, MOVING)
    for tick in range(1, 15):
        go(world)
        expected = [0.7, 0.3] if tick < 10 else [0.7, -0.3]
        assert world.areas[PREY].tolist() == expected, tick
    visit(world, go, [0.7, 0.3])
    assert world.state.readings.ground[0, 1] > 0.6  # the floor
    visit(world, go, [0.7, -0.3])
    assert world.state.readings.ground[0, 1] < 0.66
    world.reset([0])
    world.sense_first()
    assert world.areas[PREY].tolist() == [0.7, 0.3]


def test_what_is_nearest_is_told_by_kind():
    world = ForagingWorld([es1_with(NEST_AREA, SECOND_NEST, POOR)] * 2, [0, 1], "kinematic")
    places = np.zeros((world.rows, 2, 2))
    places[: world.n_robots, NEST] = -0.6, 0.4
    places[world.n_robots :, NEST] = -0.6, -0.1
    found = nearest_areas(world.worlds, places)
    assert_array_equal(found[: world.n_robots, NEST], [[-0.5, 0.4]] * world.n_robots)
    assert_array_equal(found[world.n_robots :, NEST], [[-0.7, 0.0]] * world.n_robots)
    assert_array_equal(found[:, PREY], [[0.7, 0.0]] * world.rows)


@pytest.mark.parametrize(
    ("areas", "parts"),
    [
        ([NEST_AREA], ["task.areas", "kind 'prey'"]),
        ([POOR, RICH], ["kind 'nest'"]),
        ([NEST_AREA, POOR, {**RICH, "centre": [0.7, 0.19]}], ["task.areas[2]", "task.areas[1]"]),
        (
            [NEST_AREA, {**MOVING, "moves_to": [-0.6, 0.0]}],
            ["task.areas[0] before or after its move"],
        ),
        ([NEST_AREA, {**POOR, "centre": [0.8, 0.0]}], ["task.areas[1]", "outside the arena"]),
        ([NEST_AREA, {**MOVING, "moves_to": [0.0, 0.55]}], ["(0, 0.55)", "outside the arena"]),
        ([NEST_AREA, {**POOR, "centre": [0.2, 0.1]}], ["task.areas[1]", "start circle"]),
        ([NEST_AREA, {"kind": "prey", "centre": [0.7, 0.0], "moves_at": 5.0}], ["moves_to"]),
        ([NEST_AREA, {**POOR, "worth": 0.0}], ["task.areas.1.worth=0.0", "greater than 0"]),
        ([NEST_AREA, {**POOR, "kind": "home"}], ["task.areas.1.kind='home'", "'nest' or 'prey'"]),
        ([NEST_AREA, POOR, RICH] * 3, ["9 areas", "at most 8"]),
    ],
)
def test_areas_that_cannot_be_are_refused_in_one_line(areas, parts):
    check_refused("es1", {"task.areas": areas}, parts)


def test_the_state_tells_where_all_areas_are_and_what_they_are_worth():
    env = parallel_env(es1_with(NEST_AREA, SECOND_NEST, POOR, MOVING), learn="weighting")
    env.reset(seed=0)
    for _ in range(11):
        env.step(dict.fromkeys(env.agents, np.zeros(2, np.float32)))
    state = dict(zip(env.state_layout.names, env.state().tolist(), strict=True))

    def reported(name):
        return [state[f"areas.{name}.{k}"] for k in ("x", "y", "nest", "prey", "worth")]

    first = [state[f"areas.{kind}.{k}"] for kind in ("nest", "prey") for k in ("x", "y", "worth")]
    assert first == pytest.approx([-0.7, 0.0, 1.0, 0.7, 0.0, 0.5])
    assert reported(2) == pytest.approx([-0.5, 0.4, 1.0, 0.0, 2.0])
    assert reported(3) == pytest.approx([0.7, -0.3, 0.0, 1.0, 1.0])  # it has moved
    assert [reported(k) for k in range(4, 8)] == [[0.0] * 5] * 4
    assert env.state() in env.state_space
