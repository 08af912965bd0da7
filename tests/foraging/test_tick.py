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
def test_the_motors_go_no_faster_than_they_can_whatever_is_commanded(alone, go, physics):
    state = go(alone(physics, (0.0, 0.0, 0.0)), 5.0, speaking=True)
    np.testing.assert_allclose(state.command.wheels, 5.0 / 0.06)
    assert state.command.is_speaking.all()
    np.testing.assert_allclose(state.pose[0, :2], [0.0129, 0.0], atol=1e-12)
    np.testing.assert_allclose(state.wheels, 0.129)


def test_what_a_layer_was_shown_is_not_changed_by_the_next_tick(running):
    loop = running("es1", [0], duration=60.0, cruise_speed=0.12, area_distance=0.7)
    loop.run(300)
    shown = [loop.situation, loop.exchange]
    before = [each.copy() for each in shown]
    loop.run(50)
    assert loop.situation.tobytes() != before[0].tobytes()
    for each, was in zip(shown, before, strict=True):
        assert each.tobytes() == was.tobytes()
