"""One stream for each robot and cause: drawing more for one does not move another."""

import numpy as np
import pytest

from swarm_forage_env.streams import Cause


def driven(running, command, **overrides):
    """es1 after 60 ticks of wheels and words that do not depend on what is sensed."""
    world = running("es1", [3], "kinematic", **overrides).world
    wheels = np.random.default_rng(0).uniform(-0.06, 0.06, (6, world.rows, 2))
    heard = []
    for tick in range(60):
        order = command(world, speaking=True, words=1.0)
        order.wheels[:] = wheels[tick // 10] * (tick % 10 < 5)
        heard.append(world.tick(order).heard.valid)
    return world, np.array(heard)


@pytest.mark.parametrize(
    ("name", "value", "moved"),
    [
        ("wheel_noise", 0.3, set()),
        ("proximity_noise", 0.0, set()),
        ("ground_noise", 0.0, set()),
        ("bearing_noise", 0.0, set()),
        ("frames", 30, {Cause.RADIO}),
        ("range_model", "board", {Cause.RADIO}),
        ("slots", 1, {Cause.RADIO, Cause.SLOT}),
        ("loss_far", 1.0, {Cause.RADIO, Cause.SLOT}),
        ("max_range", 0.25, {Cause.RADIO, Cause.SLOT, Cause.LOSS}),
        ("exchange_time", 9.0, set()),
    ],
)
def test_only_the_causes_that_draw_more_move(running, command, name, value, moved):
    before, _ = driven(running, command)
    after, _ = driven(running, command, **{name: value})
    np.testing.assert_array_equal(after.state.pose, before.state.pose)
    changed = {
        cause
        for cause in before.streams
        if not np.array_equal(before.streams[cause], after.streams[cause])
    }
    assert changed == moved


def test_more_wheel_noise_loses_no_other_message(running, command):
    _, before = driven(running, command)
    _, after = driven(running, command, wheel_noise=0.5)
    assert before.any()
    np.testing.assert_array_equal(after, before)


def test_a_controller_that_draws_does_not_move_the_world(running):
    worlds = [running("es1", [3], controller=name).world for name in ("nc", "ssgikf")]
    for cause in Cause:
        if cause in worlds[0].streams:
            np.testing.assert_array_equal(worlds[0].streams[cause], worlds[1].streams[cause])
    assert Cause.WANDER not in worlds[0].streams
