"""Who hears what, and when."""

import numpy as np


def everyone_near(world):
    """Put the robots on a ring on which each hears its neighbours, and settle."""
    angle = np.linspace(0.0, 2.0 * np.pi, world.n_robots, endpoint=False)
    world.state.pose[:, 0] = 0.14 * np.cos(angle)
    world.state.pose[:, 1] = 0.14 * np.sin(angle)


def test_nobody_has_spoken_before_the_first_tick(running):
    for controller in ("nc", "dsgiff"):
        loop = running("es1", [0], controller=controller)
        heard = loop.world.feedback.heard
        assert not heard.valid.any()
        assert not loop.world.state.speaking.any()
        for held in (heard.sender, heard.words, heard.beam, heard.frames):
            assert np.all(held == 0)


def test_nobody_has_spoken_after_a_reset(running, command):
    world = running("es1", [0]).world
    everyone_near(world)
    assert world.tick(command(world, speaking=True)).heard.valid.any()
    heard = world.reset([1]).heard
    assert not heard.valid.any()
    assert not world.tick(command(world)).heard.valid.any()
    assert world.state.messages.sum() == 0


def test_what_is_said_in_a_tick_is_heard_in_the_next_and_not_again(running, command):
    world = running("es1", [0]).world
    everyone_near(world)
    first = world.tick(command(world, speaking=True, words=1.0)).heard
    second = world.tick(command(world, speaking=True, words=2.0)).heard
    third = world.tick(command(world)).heard
    assert np.all(first.words[first.valid] == 1.0)
    assert np.all(second.words[second.valid] == 2.0)
    assert first.valid.any()
    assert second.valid.any()
    assert not third.valid.any()


def test_the_silent_say_nothing_whatever_their_words(running, command):
    world = running("es1", [0]).world
    everyone_near(world)
    heard = world.tick(command(world, speaking=False, words=1.0)).heard
    assert not heard.valid.any()
    assert np.all(heard.words == 0.0)


def test_empty_slots_say_nothing(running):
    loop = running("es1", [0, 1])
    n_empty = n_heard = 0
    for _ in range(600):
        heard = loop.step().heard
        empty = ~heard.valid
        n_empty += empty.sum()
        n_heard += heard.valid.sum()
        for held in (heard.sender, heard.words, heard.beam, heard.frames):
            assert np.all(held[empty] == 0)
        assert np.all(heard.frames[heard.valid] >= 1)
    assert n_empty > 0
    assert n_heard > 0


def test_nobody_hears_itself(running):
    loop = running("es1", [0, 1])
    own = np.tile(np.arange(10), 2)[:, None]
    for _ in range(600):
        heard = loop.step().heard
        assert not np.any(heard.valid & (heard.sender == own))
    assert loop.world.state.messages.sum() > 0


def test_messages_are_counted_once_for_each_robot_that_hears_them(running, command):
    world = running("es1", [0]).world
    everyone_near(world)
    expected = sum(
        world.tick(command(world, speaking=True)).heard.valid.sum(axis=1) for _ in range(5)
    )
    np.testing.assert_array_equal(world.state.messages, expected)
