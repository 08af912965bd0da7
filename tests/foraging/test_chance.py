"""One stream for each robot and source of noise: drawing more of one does not move another."""

import numpy as np
import pytest

from swarm_forage_env.epuck.placing import SOURCES
from swarm_forage_env.random_streams import NoiseSource


def driven(running, go, **overrides):
    """es1 after 60 ticks of fixed wheels and talk; some robots are sent more than their slots."""
    world = running("es1", [6], "kinematic", **overrides).world
    wheels = np.random.default_rng(0).uniform(-0.06, 0.06, (6, world.rows, 2))
    heard = []
    for tick in range(60):
        state = go(world, wheels[tick // 10] * (tick % 10 < 5), speaking=True)
        heard.append(state.heard.n.copy())
    return world, np.array(heard)


@pytest.mark.parametrize(
    ("name", "value", "moved"),
    [
        ("wheel_noise", 0.3, set()),
        ("proximity_noise", 0.0, set()),
        ("ground_noise", 0.0, set()),
        ("bearing_noise", 0.0, set()),
        ("frames", 30, {NoiseSource.RADIO}),
        ("range_model", "board", {NoiseSource.RADIO}),
        ("slots", 1, {NoiseSource.RADIO, NoiseSource.SLOT}),
        ("loss_far", 1.0, {NoiseSource.RADIO, NoiseSource.SLOT}),
        ("max_range", 0.25, {NoiseSource.RADIO, NoiseSource.SLOT, NoiseSource.LOSS}),
        ("exchange_time", 9.0, set()),
    ],
)
def test_only_the_sources_that_draw_more_move(running, go, name, value, moved):
    before, heard_before = driven(running, go)
    after, heard_after = driven(running, go, **{name: value})
    np.testing.assert_array_equal(after.state.pose, before.state.pose)
    changed = {
        source
        for column, source in enumerate(SOURCES)
        if not np.array_equal(before.state.streams[:, column], after.state.streams[:, column])
    }
    assert changed == moved
    assert heard_before.any()
    if not moved:
        np.testing.assert_array_equal(heard_after, heard_before, "messages are lost as before")
