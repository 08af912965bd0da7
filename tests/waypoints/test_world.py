"""Waypoints: a world in a block is the world alone, for layers that are compiled or in NumPy."""

from dataclasses import replace
from functools import partial
from itertools import product

import numpy as np
import pytest
from numpy.testing import assert_array_equal

import baselines.controllers  # noqa: F401 enters the controllers
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.loop import Loop
from swarm_forage_env.mixed import MixedController
from swarm_forage_env.record import rows
from swarm_forage_env.registry import CONTROLLERS
from swarm_forage_env.scenarios import find_scenario
from swarm_forage_env.waypoints.world import WaypointsWorld
from tests.outside import OutsideMotionPart
from tests.worlds import check_each_is_itself, check_same_world

ESTIMATORS = ("dead_reckoning", "covariance_intersection", "decentralised_ekf")
SETTINGS = ("authors", "corrected")
TICKS = 60

every_estimator = pytest.mark.parametrize(
    ("estimator", "setting"), list(product(ESTIMATORS, SETTINGS))
)


def running(
    seeds, estimator="decentralised_ekf", setting="corrected", name="boids-adaptive",
    scenario="waypoints-25",
):  # fmt: skip
    controller = CONTROLLERS[name].with_parameters({"estimator": estimator, "setting": setting})
    return Loop(find_scenario(scenario), controller, seeds)


def beliefs(loop):
    """What the robots of all worlds believe, a row for each; writing to it changes them."""
    minds = rows(loop.controller.minds["estimator"])
    shared = loop.controller.shared
    return {
        "pose": minds.belief.pose,
        "P": minds.belief.P,
        "velocity": minds.belief.velocity,
        "reckoned": minds.reckoned.pose,
        "reckoned_P": minds.reckoned.P,
        "factors": shared.reshape(loop.world.rows, *shared.shape[2:]),
    }


@every_estimator
def test_a_world_in_a_block_is_the_world_alone(estimator, setting):
    controller = find_controller(f"boids-adaptive:estimator={estimator},setting={setting}")
    block = check_each_is_itself(find_scenario("waypoints-25"), controller, [11, 5, 8], None, 30)
    assert block.exchange.is_valid.any()


def sighted(loop, pairs):
    """Show the controller this tick again, but with these pairs alone seeing each other."""
    n, sightings = loop.world.n_robots, loop.world.sightings
    pose = beliefs(loop)["pose"].reshape(-1, n, 3)
    ways = pose[:, None, :, :2] - pose[:, :, None, :2]
    there = np.arctan2(ways[..., 1], ways[..., 0])
    sightings["seen"] = False
    sightings["range"] = np.linalg.norm(ways, axis=3).astype(np.float32) + np.float32(0.05)
    sightings["bearing"] = np.angle(np.exp(1j * (there - pose[:, :, None, 2])))
    for row, other in pairs:
        sightings["seen"][row // n, row % n, other] = True
    loop.run_stages("observe")
    loop.run_stages("decide")
    return {name: array.copy() for name, array in beliefs(loop).items()}


@every_estimator
def test_a_one_sided_sight_counts_as_much_if_others_of_the_same_world_meet(estimator, setting):
    quiet = running([3], estimator, setting, scenario="waypoints-05")
    busy = running([3], estimator, setting, scenario="waypoints-05")
    expected = sighted(quiet, [(0, 1)])
    found = sighted(busy, [(0, 1), (2, 3), (3, 2)])
    for name in expected:
        assert_array_equal(found[name][:2], expected[name][:2], name)


def test_a_claim_is_judged_where_the_robot_stood_when_it_claimed():
    world = WaypointsWorld([find_scenario("waypoints-05")], [0])
    state = world.state
    state.pose[:] = 0.0
    state.motion[:, 0] = 0.5
    state.goal[:] = [[0.1, 0.1], [0.4, 0.0], [0.1, 0.1], [0.0, 0.0], [3.0, 0.0]]
    state.command.acceleration[:], state.command.claim[:] = 0.0, [True, True, False, True, True]
    world.tick(0, 1)
    assert state.reward.tolist() == [1.0, 0.0, 0.0, 1.0, 0.0]
    assert state.right.tolist() == [1, 0, 0, 1, 0]
    assert state.wrong.tolist() == [0, 1, 0, 0, 1]
    assert_array_equal(state.readings.goal, state.goal.astype(np.float32))


def test_an_engine_with_contacts_is_refused():
    with pytest.raises(ConfigError, match=r"physics='rigid'.*waypoints-05 has no contacts"):
        WaypointsWorld([find_scenario("waypoints-05")], [0], physics="rigid")


def meets(seen, robots):
    """Who sees any of some robots, or is seen by one."""
    return seen[:, robots].any(axis=1) | seen[robots].any(axis=0)


class Moment:
    """A running world as it is now, to come back to."""

    def __init__(self, loop):
        self._arrays = loop.controller.minds, loop.controller.shared, loop.world.robots
        self._kept = [array.copy() for array in self._arrays]

    def restore(self, robots=True):
        for array, kept in zip(self._arrays[: 3 if robots else 2], self._kept, strict=False):
            array[...] = kept


def decided(loop, moment):
    """What is commanded next at a moment."""
    moment.restore()
    loop.run_stages("decide")
    return loop.world.state.command.copy()


@every_estimator
def test_a_robot_that_meets_nobody_moves_nobody_else(estimator, setting):
    loop = running([9], estimator, setting, scenario="waypoints-10")
    rng, lonely_ticks, moved = np.random.default_rng(0), 0, 0
    for _ in range(100):
        lonely = ~meets(loop.world.sightings["seen"][0], np.ones(10, np.bool_))
        before = Moment(loop)
        for array in beliefs(loop).values():
            array[lonely] += rng.uniform(0.1, 1.0) * array[lonely]
        loop.run_stages("decide")
        perturbed = Moment(loop)
        before.restore()
        loop.step()
        truth, expected = Moment(loop), {name: a.copy() for name, a in beliefs(loop).items()}
        others = ~lonely & ~meets(loop.world.sightings["seen"][0], lonely)
        perturbed.restore(robots=False)
        loop.run_stages("observe")
        twin = Moment(loop)
        for name, found in beliefs(loop).items():
            assert_array_equal(found[others], expected[name][others], name)
        mine, theirs = decided(loop, twin), decided(loop, truth)
        assert_array_equal(mine[others], theirs[others])
        truth.restore()
        lonely_ticks += lonely.any() and others.any()
        moved += np.any(mine.acceleration[lonely] != theirs.acceleration[lonely])
    assert lonely_ticks > 20
    assert moved > 20


def test_a_world_reset_alone_goes_on_as_the_world_alone():
    plain = find_scenario("waypoints-05")
    other = find_scenario(
        "waypoints-05", {"side": 6.0, "reach": 2.0, "max_speed": 0.4, "tick": 0.4}
    )
    loop_of = partial(Loop, controller=CONTROLLERS["boids-adaptive"])
    block, twin = (loop_of(plain, seeds=[4, 9, 2]) for _ in range(2))
    for each in (block, twin):
        each.run(TICKS)
    block.reset([7, 21], worlds=[2, 0], scenarios=[plain, other])
    alone, again = loop_of(other, seeds=[21]), loop_of(plain, seeds=[7])
    for _ in range(TICKS):
        check_same_world(block, 0, alone)
        check_same_world(block, 1, twin, 1)
        check_same_world(block, 2, again)
        for loop in (block, twin, alone, again):
            loop.step()
    assert block.world.is_over.tolist() == [False, False, False]


class Whole:
    """Every correction is carried out, as a weighting in NumPy."""

    tasks = ("waypoints",)
    heard_p_share = 0.0

    def __call__(self, exchange):
        return np.ones((len(exchange), 1), np.float32)


def mixed(*controllers):
    return MixedController(tuple(controllers[i % len(controllers)] for i in range(25)))


def ran(controller, ticks=TICKS):
    loop = Loop(find_scenario("waypoints-25"), controller, [3, 4])
    loop.run(ticks)
    return loop


@pytest.mark.parametrize("estimator", ESTIMATORS[1:])
def test_the_same_layers_compiled_and_in_numpy_in_one_swarm_are_the_uniform_swarm(estimator):
    compiled = CONTROLLERS["boids-adaptive"].with_parameters({"estimator": estimator})
    swarm = mixed(
        compiled,
        replace(compiled, weighting=Whole()),
        replace(compiled, motion=OutsideMotionPart(compiled.motion, ("waypoints",))),
    )
    one, other = ran(compiled), ran(swarm)
    assert_array_equal(one.world.robots["pose"], other.world.robots["pose"])
    beliefs = (loop.controller.minds["estimator"]["belief"] for loop in (one, other))
    assert_array_equal(*beliefs)
    assert_array_equal(one.controller.shared, other.controller.shared)
    assert np.abs(one.world.sightings["seen"]).sum() > 0


def test_every_robot_goes_by_its_own_gains():
    goal, static = (CONTROLLERS[name] for name in ("boids-goal", "boids-static"))
    first = [ran(each, 1).world.robots["command"]["acceleration"] for each in (goal, static)]
    both = ran(mixed(goal, static), 1).world.robots["command"]["acceleration"]
    assert_array_equal(both[:, ::2], first[0][:, ::2])
    assert_array_equal(both[:, 1::2], first[1][:, 1::2])
    assert np.any(first[0] != first[1])
