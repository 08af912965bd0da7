"""One tick: motors, walls, sensors, the end of an episode."""

import numpy as np
import pytest

from swarm_forage_env.errors import UnknownNameError
from swarm_forage_env.scenarios import find_scenario
from swarm_forage_env.world import World

ENGINES = ("rigid", "kinematic")


@pytest.mark.parametrize("physics", ENGINES)
def test_a_free_robot_goes_where_its_wheels_take_it(running, command, physics):
    world = running("es1", [0], physics, n_robots=1).world
    world.state.pose[:] = 0.0
    for _ in range(10):
        world.tick(command(world, (0.05, 0.06)))
    turn = 0.01 / 0.053
    x, y = 0.055 / turn * np.sin(turn), 0.055 / turn * (1.0 - np.cos(turn))
    np.testing.assert_allclose(world.state.pose[0], [x, y, turn], atol=1e-5)


@pytest.mark.parametrize("physics", ENGINES)
def test_the_motors_go_no_faster_than_they_can(running, command, physics):
    world = running("es1", [0], physics, n_robots=1).world
    world.state.pose[:] = 0.0
    world.tick(command(world, 5.0))
    np.testing.assert_allclose(world.state.pose[0, :2], [0.0129, 0.0], atol=1e-12)
    np.testing.assert_allclose(world.state.wheels, 0.129)


@pytest.mark.parametrize("physics", ENGINES)
def test_a_wall_stops_a_robot_and_its_encoders_do_not_notice(running, command, physics):
    world = running("es1", [0], physics, n_robots=1, wheel_noise=0.0).world
    world.state.pose[:] = [0.80, 0.0, 0.0]
    for _ in range(20):
        readings = world.tick(command(world, 0.06)).readings
    assert world.state.pose[0, 0] == pytest.approx(0.815, abs=2e-4)
    assert readings.odometry[0, 0] == pytest.approx(0.006)


@pytest.mark.parametrize("physics", ENGINES)
def test_two_robots_head_on_stop_each_other(running, command, physics):
    world = running("es1", [0], physics, n_robots=2).world
    world.state.pose[:] = [[-0.05, 0.0, 0.0], [0.05, 0.0, -np.pi]]
    for _ in range(30):
        world.tick(command(world, 0.06))
    apart = np.hypot(*(world.state.pose[0, :2] - world.state.pose[1, :2]))
    assert apart == pytest.approx(0.07, abs=1e-3)


def test_a_moving_robot_pushes_one_at_rest(running, command):
    world = running("es1", [0], "rigid", n_robots=2).world
    world.state.pose[:] = [[-0.08, 0.0, 0.0], [0.0, 0.0, 0.0]]
    order = command(world)
    order.wheels[0] = 0.06
    for _ in range(20):
        world.tick(order)
    assert world.state.pose[1, 0] > 0.03


def test_sensors_see_where_the_robots_are_after_the_tick(running, command):
    world = running("es1", [0], n_robots=1, proximity_noise=0.0, ground_noise=0.0).world
    world.state.pose[:] = [0.79, 0.0, 0.0]
    assert world.tick(command(world)).readings.proximity[0, 0] > 0.0
    world.state.pose[:] = [world.areas[0, 0] - 0.03, 0.0, 0.0]
    assert world.tick(command(world)).readings.ground.tolist() == [[0.0, 0.0, 0.0]]


def test_an_episode_is_over_after_its_duration(running, command):
    world = running("es1", [0, 1], duration=0.5).world
    done = [world.tick(command(world)).done.tolist() for _ in range(6)]
    assert done == [[False, False]] * 4 + [[True, True]] * 2


def test_the_reward_is_the_round_trip_in_its_tick(running, command):
    world = running("es1", [0], n_robots=1).world
    nest, prey = world.areas[:, 0] - 0.03
    rewards = []
    for x in (nest, prey, nest, 0.0):
        world.state.pose[:] = [x, 0.0, 0.0]
        rewards.append(float(world.tick(command(world)).reward[0]))
    assert rewards == [0.0, 0.0, 1.0, 0.0]


def test_feedback_of_a_tick_is_not_changed_by_the_next(running):
    loop = running("es1", [0])
    before = loop.step()
    kept = [before.readings.proximity.copy(), before.readings.odometry.copy(),
            before.heard.words.copy(), before.reward.copy()]  # fmt: skip
    loop.step()
    after = [before.readings.proximity, before.readings.odometry, before.heard.words, before.reward]
    for was, is_now in zip(kept, after, strict=True):
        np.testing.assert_array_equal(is_now, was)


def test_a_command_is_not_changed_by_the_world(running, command):
    world = running("es1", [0]).world
    order = command(world, 5.0, speaking=True, words=2.0)
    world.tick(order)
    assert np.all(order.wheels == 5.0)


def test_an_unknown_engine_is_refused_with_the_nearest_name():
    with pytest.raises(UnknownNameError, match="engine named 'rigit', did you mean 'rigid'"):
        World(find_scenario("es1"), [0], "rigit")


def test_areas_are_met_only_outside_the_start_circle(running):
    for name in ("es1", "es2", "es3", "real", "ants2008"):
        scenario = find_scenario(name)
        world = World(scenario, range(3))
        for area in world.areas:
            d = np.hypot(*(world.state.pose[:, :2] - area).T)
            assert d.min() >= scenario.task.area_radius
