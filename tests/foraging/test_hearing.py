"""Who hears whom, and when."""

import numpy as np


def everyone_near(world):
    """Put the robots on a ring on which each hears its neighbours."""
    angle = np.linspace(0.0, 2.0 * np.pi, world.n_robots, endpoint=False)
    world.state.pose[:, 0] = 0.14 * np.cos(angle)
    world.state.pose[:, 1] = 0.14 * np.sin(angle)


def test_nobody_has_spoken_before_the_first_tick(running):
    for controller in ("nc", "dsgiff"):
        loop = running("es1", [0], controller=controller)
        assert not loop.world.state.heard.n.any()
        assert not loop.world.state.command.is_speaking.any()
        assert not loop.world.state.heard.is_valid.any()
        assert not loop.world.state.heard.range_bearing.any()


def test_nobody_has_spoken_after_a_reset(running, go):
    world = running("es1", [0]).world
    everyone_near(world)
    assert go(world, speaking=True).heard.n.any()
    world.reset([1])
    assert not world.state.heard.n.any()
    assert not world.state.command.is_speaking.any()
    assert not go(world).heard.n.any()
    assert world.state.messages.sum() == 0


def test_what_is_said_in_a_tick_is_heard_in_it_and_not_again(running, go):
    world = running("es1", [0]).world
    everyone_near(world)
    assert go(world, speaking=True).heard.n.any()
    assert go(world, speaking=True).heard.n.any()
    assert not go(world).heard.n.any()


def test_a_listener_hears_only_who_speaks(running, go):
    world = running("es1", [0], loss_far=0.01).world
    everyone_near(world)
    speaking = np.arange(world.n_robots) % 3 == 0
    state = go(world, speaking=speaking)
    for sender, n in zip(state.heard.sender, state.heard.n, strict=True):
        assert speaking[sender[:n]].all()
    assert state.heard.n.any()


def test_empty_slots_say_nothing(running):
    loop = running("es1", [0, 1])
    n_empty = n_heard = 0
    for _ in range(600):
        loop.step()
        heard = loop.world.state.heard
        is_full = heard.is_valid > 0
        n_empty += np.sum(~is_full)
        n_heard += np.sum(is_full)
        assert not heard.range_bearing[~is_full].any()
        assert not heard.n_averaged[~is_full].any()
        assert np.all(heard.n_averaged[is_full] >= 1)
        np.testing.assert_array_equal(is_full, np.arange(is_full.shape[1]) < heard.n[:, None])
    assert n_empty > 0
    assert n_heard > 0


def test_nobody_hears_itself(running):
    loop = running("es1", [0, 1])
    own = np.tile(np.arange(10), 2)[:, None]
    for _ in range(600):
        loop.step()
        heard = loop.world.state.heard
        assert not np.any((heard.is_valid > 0) & (heard.sender == own))
    assert loop.world.state.messages.sum() > 0


def test_messages_are_counted_once_for_each_robot_that_hears_them(running, go):
    world = running("es1", [0]).world
    everyone_near(world)
    expected = sum(go(world, speaking=True).heard.n.copy() for _ in range(5))
    np.testing.assert_array_equal(world.state.messages, expected)
