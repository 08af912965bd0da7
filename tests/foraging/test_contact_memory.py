"""A space that remembers what another one did goes on as that one, however its bodies touch."""

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from swarm_forage_env.foraging.world import ForagingWorld
from swarm_forage_env.scenarios import find_scenario
from tests.foraging.conftest import CROWD


def into_the_middle(world):
    """Wheels that drive every robot at full speed into one clump [m/s]."""
    x, y, theta = world.state.pose.T
    off = np.angle(np.exp(1j * (np.arctan2(-y, -x) - theta)))
    speed = world.scenario.robot.max_speed
    return speed * np.clip(np.stack([1.0 - off, 1.0 + off], axis=1), -1.0, 1.0)


@pytest.mark.parametrize(("n_robots", "before"), [(1, 40), (2, 7), (15, 0), (15, 1), (15, 30),
                                                  (15, 97), (15, 201), (15, 460)])  # fmt: skip
def test_robots_in_a_clump_go_on_bit_for_bit(go, n_robots, before):
    scenario = find_scenario("es1", {**CROWD, "n_robots": n_robots})
    used, copied = (ForagingWorld([scenario], [before], "rigid") for _ in range(2))
    noise = 0.04 * np.random.default_rng(1).normal(size=(before + 250, n_robots, 2))
    for tick, push in enumerate(noise):
        if tick == before:
            copied._physics.restore(copied._physics.snapshot(), copied.scenarios)
        go(used, into_the_middle(used) + push)
        go(copied, into_the_middle(copied) + push)
        assert_array_equal(used.state.pose, copied.state.pose)
