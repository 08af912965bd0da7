"""One tick: motors, contacts, and what a layer was shown."""

import numpy as np
import pytest

ENGINES = ("rigid", "kinematic")


@pytest.fixture
def alone(running):
    """A world of one robot, or a few, at given places."""

    def put(physics, *places, **overrides):
        world = running("es1", [0], physics, n_robots=len(places), **overrides).world
        world.state.pose[:] = places
        return world

    return put


@pytest.mark.parametrize("physics", ENGINES)
def test_a_free_robot_goes_where_its_wheels_take_it(alone, go, physics):
    world = alone(physics, (0.0, 0.0, 0.0))
    for _ in range(10):
        state = go(world, (0.05, 0.06))
    turn = 0.01 / 0.053
    x, y = 0.055 / turn * np.sin(turn), 0.055 / turn * (1.0 - np.cos(turn))
    np.testing.assert_allclose(state.pose[0], [x, y, turn], atol=1e-5)


@pytest.mark.parametrize("physics", ENGINES)
def test_the_motors_go_no_faster_than_they_can_whatever_is_commanded(alone, go, physics):
    state = go(alone(physics, (0.0, 0.0, 0.0)), 5.0, speaking=True)
    np.testing.assert_allclose(state.command.wheels, 5.0 / 0.06)
    assert state.command.is_speaking.all()
    np.testing.assert_allclose(state.pose[0, :2], [0.0129, 0.0], atol=1e-12)
    np.testing.assert_allclose(state.wheels, 0.129)


def test_the_kernel_moves_no_robot_that_the_engine_has_moved(alone, go):
    # In a contact the engine slides both; the kernel would add the path of the wheels to that.
    world = alone("rigid", (-0.036, 0.0, 0.0), (0.036, 0.0, 0.0))
    before = world.state.pose.copy()
    state = go(world, 0.06)
    np.testing.assert_allclose(state.pose - before, [[0.006, 0.0, 0.0]] * 2, atol=1e-4)
    assert not world.worlds["has_moved"].any()


def test_what_a_layer_was_shown_is_not_changed_by_the_next_tick(running):
    loop = running("es1", [0], duration=60.0, cruise_speed=0.12, area_distance=0.7)
    loop.run(300)
    shown = [loop.situation, loop.exchange]
    before = [each.copy() for each in shown]
    loop.run(50)
    assert loop.situation.tobytes() != before[0].tobytes()
    for each, was in zip(shown, before, strict=True):
        assert each.tobytes() == was.tobytes()


def test_only_the_worlds_that_are_asked_for_move(running, go):
    world = running("es1", [0, 1, 2], "kinematic").world
    before = world.robots.copy()
    world.robots["command"]["wheels"] = 1.0
    world.tick(1, 2)
    assert world.worlds["ticks"].tolist() == [0, 1, 0]
    moved = (world.robots["pose"] != before["pose"]).any(axis=(1, 2))
    assert moved.tolist() == [False, True, False]
