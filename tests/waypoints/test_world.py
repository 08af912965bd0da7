"""The waypoints world: one seed is one trajectory, a world in a block is the world alone."""

import pickle
from copy import deepcopy
from itertools import product

import numpy as np
import pytest
from numpy.testing import assert_array_equal

import baselines.controllers  # noqa: F401 enters the controllers
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.loop import Loop
from swarm_forage_env.record import rows
from swarm_forage_env.registry import CONTROLLERS
from swarm_forage_env.scenarios import find_scenario
from swarm_forage_env.waypoints.world import WaypointsWorld
from tests.columns import columns

ESTIMATORS = ("dead_reckoning", "covariance_intersection", "decentralised_ekf")
SETTINGS = ("authors", "corrected")
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
    controller = CONTROLLERS[name].with_parameters({"estimator": estimator, "setting": setting})
    return Loop(find_scenario(scenario), controller, seeds)


def everything(loop, world=0):
    """All that is true, sensed, believed and drawn in one world of a block, by name."""
    found = dict(columns(loop.world.robots[world], "robot"))
    found |= columns(loop.world.sightings[world], "sighting")
    found |= columns(loop.controller.minds[world], "mind")
    found |= {"factors": loop.controller.shared[world]}
    found |= {"ticks": loop.world.worlds["ticks"][[world]]}
    return deepcopy(found)


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


def assert_same(one, other):
    assert one.keys() == other.keys()
    different = [name for name in one if not np.array_equal(one[name], other[name])]
    assert not different


@every_estimator
def test_a_world_in_a_block_is_the_world_alone(estimator, setting):
    seeds = [11, 5, 8]
    block = running(seeds, estimator, setting)
    alone = [running([seed], estimator, setting) for seed in seeds]
    corrections = 0
    for _ in range(TICKS):
        block.step()
        corrections += np.count_nonzero(block.exchange.is_valid)
        for world, each in enumerate(alone):
            each.step()
            assert_same(everything(block, world), everything(each))
    assert corrections > 100


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


def test_controllers_under_one_seed_meet_the_same_world():
    names = ("boids-goal", "boids-static", "boids-adaptive")
    loops = [running([6], *each) for each in product(ESTIMATORS, SETTINGS, names)]
    first = everything(loops[0])
    for loop in loops[1:]:
        found = everything(loop)
        for name in first:
            if name.startswith(("robot.", "sighting.")):
                assert_array_equal(found[name], first[name], name)
    for loop in loops:
        for _ in range(20):
            loop.step()
        for name in ("robot.bias", "robot.deviation"):
            assert_array_equal(everything(loop)[name], first[name], name)


def world_of(scenario, seeds=(0,), overrides=None, **options):
    """A block of worlds under one scenario."""
    each = [find_scenario(scenario, overrides)] * len(seeds)
    return WaypointsWorld(each, seeds, **options)


def told(world, acceleration, claim):
    """One tick of a block under a command."""
    world.robots["command"]["acceleration"] = acceleration
    world.robots["command"]["claim"] = claim
    world.tick(0, world.n_worlds)


def test_the_next_goal_of_a_robot_does_not_depend_on_when_it_claims():
    soon, late = world_of("waypoints-05", [3]), world_of("waypoints-05", [3])
    for tick in range(10):
        first = soon.state.goal.copy()
        told(soon, 0.0, tick in (0, 1))
        told(late, 0.0, tick in (6, 9))
        assert np.all(soon.state.goal != first) == (tick < 2)
    assert_array_equal(soon.state.goal, late.state.goal)


def test_an_engine_with_contacts_is_refused():
    with pytest.raises(ConfigError, match=r"physics='rigid'.*waypoints-05 has no contacts"):
        world_of("waypoints-05", physics="rigid")


def test_a_block_is_reset_with_one_seed_for_each_world():
    world = world_of("waypoints-05", [0, 1])
    with pytest.raises(ConfigError, match=r"seeds=\[1\].*2"):
        world.reset([1])


def test_a_claim_is_judged_where_the_robot_stood_when_it_claimed():
    world = world_of("waypoints-05")
    state = world.state
    state.pose[:] = 0.0
    state.motion[:, 0] = 0.5
    state.goal[:] = [[0.1, 0.1], [0.4, 0.0], [0.1, 0.1], [0.0, 0.0], [3.0, 0.0]]
    told(world, 0.0, [True, True, False, True, True])
    assert state.reward.tolist() == [1.0, 0.0, 0.0, 1.0, 0.0]
    assert state.right.tolist() == [1, 0, 0, 1, 0]
    assert state.wrong.tolist() == [0, 1, 0, 0, 1]
    assert_array_equal(state.readings.goal, state.goal.astype(np.float32))


def test_the_number_of_threads_changes_nothing():
    scenario, controller = find_scenario("waypoints-10"), CONTROLLERS["boids-adaptive"]
    one, three = (Loop(scenario, controller, [4, 5, 6], threads=n) for n in (1, 3))
    for _ in range(TICKS):
        one.step()
        three.step()
    for world in range(3):
        assert_same(everything(one, world), everything(three, world))


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
    """What is commanded next at a moment: acceleration and claim."""
    moment.restore()
    loop.run_stages("decide")
    command = loop.world.state.command
    return command.acceleration.copy(), command.claim.copy()


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
        assert_array_equal(mine[0][others], theirs[0][others])
        assert_array_equal(mine[1][others], theirs[1][others])
        truth.restore()
        lonely_ticks += lonely.any() and others.any()
        moved += np.any(mine[0][lonely] != theirs[0][lonely])
    assert lonely_ticks > 20
    assert moved > 20


def loop_of(scenario, seeds):
    return Loop(scenario, CONTROLLERS["boids-adaptive"], seeds)


def test_a_world_reset_alone_goes_on_as_the_world_alone():
    plain = find_scenario("waypoints-05")
    other = find_scenario(
        "waypoints-05", {"side": 6.0, "reach": 2.0, "max_speed": 0.4, "tick": 0.4}
    )
    block, twin = (loop_of(plain, [4, 9, 2]) for _ in range(2))
    for _ in range(TICKS):
        block.step()
        twin.step()
    block.reset([7, 21], worlds=[2, 0], scenarios=[plain, other])
    alone, again = loop_of(other, [21]), loop_of(plain, [7])
    for _ in range(TICKS):
        assert_same(everything(block, 0), everything(alone))
        assert_same(everything(block, 1), everything(twin, 1))
        assert_same(everything(block, 2), everything(again))
        for loop in (block, twin, alone, again):
            loop.step()
    assert block.world.is_over.tolist() == [False, False, False]


@every_estimator
def test_a_copy_and_a_snapshot_go_on_bit_for_bit(estimator, setting):
    loop, twin = (running([4, 9], estimator, setting) for _ in range(2))
    for _ in range(20):
        loop.step()
        twin.step()
    kept, copies = loop.snapshot(), [deepcopy(loop), pickle.loads(pickle.dumps(loop))]
    for _ in range(20):
        for each in (loop, twin, *copies):
            each.step()
    for _ in range(2):
        for each in (loop, *copies):
            assert_same(everything(each, 1), everything(twin, 1))
        loop.restore(kept)
        for _ in range(20):
            loop.step()
