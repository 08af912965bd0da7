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
