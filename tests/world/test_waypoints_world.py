"""The waypoints world: one seed is one trajectory, a world in a block is the world alone."""

from copy import deepcopy
from dataclasses import fields, replace
from itertools import product

import numpy as np
import pytest
from numpy.testing import assert_array_equal

import baselines.recipes  # noqa: F401 enters the controllers
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.loop import WaypointsLoop
from swarm_forage_env.scenarios import find_scenario
from swarm_forage_env.streams import Cause
from swarm_forage_env.waypoints_interface import WaypointCommand
from swarm_forage_env.waypoints_world import WaypointsWorld

ESTIMATORS = ("dead_reckoning", "covariance_intersection", "decentralised_ekf")
SETTINGS = ("authors", "corrected")
BELIEFS = ("pose", "P", "velocity", "factors", "reckoned", "reckoned_P")
TICKS = 60

every_estimator = pytest.mark.parametrize(
    ("estimator", "setting"), list(product(ESTIMATORS, SETTINGS))
)


def running(
    seeds,
    estimator="decentralised_ekf",
    setting="corrected",
    name="boids-adaptive",
    scenario="waypoints-25",
):
    recipe = find_controller(f"{name}:estimator={estimator},setting={setting}")
    return WaypointsLoop(find_scenario(scenario), recipe, seeds)


def arrays_of(thing, name):
    return {f"{name}.{each.name}": getattr(thing, each.name) for each in fields(thing)}


def everything(loop, world=0):
    """All that is true, sensed, believed and drawn in one world of a block, by name."""
    feedback, estimator = loop.world.feedback, loop.controller.estimator
    found = arrays_of(loop.world.state, "state") | arrays_of(feedback.readings, "readings")
    found |= arrays_of(feedback.heard, "heard") | {"reward": feedback.reward}
    found |= arrays_of(estimator.situation, "situation")
    found |= arrays_of(estimator.encounter, "encounter") | {"done": feedback.done}
    found |= {name: getattr(estimator, name) for name in BELIEFS}
    found |= {cause.name: words for cause, words in loop.world.streams.items()}

    def rows_of(array):
        n = len(array) // loop.world.n_worlds
        return array[world * n : (world + 1) * n]

    return {name: rows_of(array).copy() for name, array in found.items()}


def assert_same(one, other):
    assert one.keys() == other.keys()
    different = [name for name in one if not np.array_equal(one[name], other[name])]
    assert not different


@every_estimator
def test_one_seed_one_trajectory(estimator, setting):
    first, second = running([4], estimator, setting), running([4], estimator, setting)
    for _ in range(TICKS):
        first.step()
        second.step()
        assert_same(everything(first), everything(second))


def test_other_seeds_are_other_worlds():
    block = running([4, 5])
    one, other = everything(block, 0), everything(block, 1)
    for name in ("state.pose", "state.goal", "state.bias", "state.deviation"):
        assert np.all(one[name] != other[name]), name


@every_estimator
def test_a_world_in_a_block_is_the_world_alone(estimator, setting):
    seeds = [11, 5, 8]
    block = running(seeds, estimator, setting)
    alone = [running([seed], estimator, setting) for seed in seeds]
    corrections = 0
    for _ in range(TICKS):
        block.step()
        corrections += np.count_nonzero(block.controller.estimator.encounter.valid)
        for world, each in enumerate(alone):
            each.step()
            assert_same(everything(block, world), everything(each))
    assert corrections > 100


@every_estimator
def test_a_sparse_world_in_a_block_is_the_world_alone_to_the_end(estimator, setting):
    seeds = [5, 1, 2**64 - 1]
    block = running(seeds, estimator, setting, scenario="waypoints-10")
    alone = [running([seed], estimator, setting, scenario="waypoints-10") for seed in seeds]
    for _ in range(200):
        block.step()
        for each in alone:
            each.step()
    for world, each in enumerate(alone):
        assert_same(everything(block, world), everything(each))


def sighted(loop, pairs):
    """Show the controller this tick again, but with these pairs alone seeing each other."""
    feedback, estimator = loop.world.feedback, loop.controller.estimator
    n, pose = loop.world.n_robots, estimator.pose.reshape(-1, loop.world.n_robots, 3)
    ways = (pose[:, None, :, :2] - pose[:, :, None, :2]).reshape(-1, n, 2)
    there = np.arctan2(ways[..., 1], ways[..., 0])
    heard = replace(
        feedback.heard,
        seen=np.zeros_like(feedback.heard.seen),
        range=np.linalg.norm(ways, axis=2).astype(np.float32) + np.float32(0.05),
        bearing=np.angle(np.exp(1j * (there - estimator.pose[:, 2:]))).astype(np.float32),
    )
    for row, other in pairs:
        heard.seen[row, other] = True
    loop.controller.observe(replace(feedback, heard=heard))
    loop.controller.command()
    return {name: getattr(estimator, name) for name in BELIEFS}


@every_estimator
def test_a_one_sided_sight_counts_as_much_if_robots_of_another_world_meet(estimator, setting):
    alone = running([3], estimator, setting, scenario="waypoints-05")
    block = running([3, 4], estimator, setting, scenario="waypoints-05")
    expected = sighted(alone, [(0, 1)])
    found = sighted(block, [(0, 1), (7, 3), (8, 2)])
    for name in BELIEFS:
        assert_array_equal(found[name][:5], expected[name], name)


@every_estimator
def test_a_one_sided_sight_counts_as_much_if_others_of_the_same_world_meet(estimator, setting):
    quiet = running([3], estimator, setting, scenario="waypoints-05")
    busy = running([3], estimator, setting, scenario="waypoints-05")
    expected = sighted(quiet, [(0, 1)])
    found = sighted(busy, [(0, 1), (2, 3), (3, 2)])
    for name in BELIEFS:
        assert_array_equal(found[name][:2], expected[name][:2], name)


def test_controllers_under_one_seed_meet_the_same_world():
    names = ("boids-goal", "boids-static", "boids-adaptive")
    loops = [running([6], *each) for each in product(ESTIMATORS, SETTINGS, names)]
    first = everything(loops[0])
    for loop in loops[1:]:
        found = everything(loop)
        for name in first:
            if name.startswith(("state", "readings", "heard")) or name in Cause.__members__:
                assert_array_equal(found[name], first[name], name)
    for loop in loops:
        for _ in range(20):
            loop.step()
        for name in ("state.bias", "state.deviation"):
            assert_array_equal(everything(loop)[name], first[name], name)


def test_the_next_goal_of_a_robot_does_not_depend_on_when_it_claims():
    scenario = find_scenario("waypoints-05")
    soon, late = WaypointsWorld(scenario, [3]), WaypointsWorld(scenario, [3])
    pull = np.zeros((5, 2), np.float32)
    for tick in range(10):
        first = soon.state.goal.copy()
        soon.tick(WaypointCommand(pull, np.full(5, tick in (0, 1))))
        late.tick(WaypointCommand(-pull, np.full(5, tick in (6, 9))))
        assert np.all(soon.state.goal != first) == (tick < 2)
    assert_array_equal(soon.state.goal, late.state.goal)


def test_an_engine_with_contacts_is_refused():
    with pytest.raises(ConfigError, match=r"physics='rigid'.*waypoints-05 has no contacts"):
        WaypointsWorld(find_scenario("waypoints-05"), [0], "rigid")


def test_a_block_is_reset_with_one_seed_for_each_world():
    world = WaypointsWorld(find_scenario("waypoints-05"), [0, 1])
    with pytest.raises(ConfigError, match=r"seeds=\[1\].*2"):
        world.reset([1])


@pytest.mark.parametrize("seed", [-1, 1.5, "one", None, 2**64])
def test_a_bad_seed_is_refused_by_name(seed):
    with pytest.raises(ConfigError, match="seed="):
        WaypointsWorld(find_scenario("waypoints-05"), [seed])


def test_an_episode_is_over_after_its_duration():
    world = WaypointsWorld(find_scenario("waypoints-05", {"task.duration": 2.0}), [0, 1])
    nothing = WaypointCommand(np.zeros((10, 2), np.float32), np.zeros(10, np.bool_))
    done = [world.tick(nothing).done.tolist() for _ in range(5)]
    assert done == [[False, False]] * 3 + [[True, True]] * 2


def test_robots_begin_with_an_exact_fix_and_nothing_earned():
    world = WaypointsWorld(find_scenario("waypoints-10"), [2])
    readings = world.feedback.readings
    assert readings.at_home.all()
    assert_array_equal(readings.fix, world.state.pose.astype(np.float32))
    assert not readings.motion.any()
    assert not world.feedback.reward.any()
    assert np.abs(world.state.pose[:, :2]).max() <= 1.0
    assert world.state.goal.min() >= 1.0
    assert world.state.goal.max() <= 5.0


def test_a_claim_is_judged_where_the_robot_stood_when_it_claimed():
    world = WaypointsWorld(find_scenario("waypoints-05"), [0])
    world.state.pose[:] = 0.0
    world.state.motion[:, 0] = 0.5
    world.state.goal[:] = [[0.1, 0.1], [0.4, 0.0], [0.1, 0.1], [0.0, 0.0], [3.0, 0.0]]
    claim = np.array([True, True, False, True, True])
    feedback = world.tick(WaypointCommand(np.zeros((5, 2), np.float32), claim))
    assert feedback.reward.tolist() == [1.0, 0.0, 0.0, 1.0, 0.0]
    assert world.state.right.tolist() == [1, 0, 0, 1, 0]
    assert world.state.wrong.tolist() == [0, 1, 0, 0, 1]
    assert_array_equal(feedback.readings.goal, world.state.goal.astype(np.float32))


def test_claims_of_the_last_tick_are_judged_by_one_more_call():
    loop = running([3], scenario="waypoints-05")
    loop.step()
    loop.world.state.goal[:] = loop.world.state.pose[:, :2]
    reward = loop.world.judge(np.ones(5, np.bool_))
    assert reward.tolist() == [1.0] * 5
    assert loop.world.state.ticks.tolist() == [1]


def test_feedback_of_a_tick_is_not_changed_by_the_next():
    loop = running([0])
    feedback = loop.step()
    parts = (feedback.readings, feedback.heard)
    before = [value.copy() for part in parts for value in arrays_of(part, "").values()]
    for _ in range(5):
        loop.step()
    after = [value for part in parts for value in arrays_of(part, "").values()]
    for was, is_now in zip(before, after, strict=True):
        assert_array_equal(is_now, was)


def meets(heard, robots):
    """Who sees any of some robots, or is seen by one."""
    return heard.seen[:, robots].any(axis=1) | heard.seen[robots].any(axis=0)


@every_estimator
def test_a_robot_that_meets_nobody_moves_nobody_else(estimator, setting):
    loop = running([9], estimator, setting, scenario="waypoints-10")
    rng, lonely_ticks, moved = np.random.default_rng(0), 0, 0
    for _ in range(100):
        lonely = ~meets(loop.world.feedback.heard, np.ones(10, np.bool_))
        twin = deepcopy(loop.controller)
        for name in BELIEFS:
            array = getattr(twin.estimator, name)
            array[lonely] += rng.uniform(0.1, 1.0) * array[lonely]
        twin.command()
        feedback = loop.step()
        twin.observe(feedback)
        others = ~lonely & ~meets(feedback.heard, lonely)
        for name in BELIEFS:
            mine, theirs = getattr(twin.estimator, name), getattr(loop.controller.estimator, name)
            assert_array_equal(mine[others], theirs[others], name)
        mine, theirs = twin.command(), deepcopy(loop.controller).command()
        assert_array_equal(mine.pull[others], theirs.pull[others])
        assert_array_equal(mine.claim[others], theirs.claim[others])
        lonely_ticks += lonely.any() and others.any()
        moved += np.any(mine.pull[lonely] != theirs.pull[lonely])
    assert lonely_ticks > 20
    assert moved > 20
