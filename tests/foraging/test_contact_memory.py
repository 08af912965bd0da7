"""A space that remembers what another one did goes on as that one, however its bodies touch."""

import pickle

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from swarm_forage_env.foraging.world import ForagingWorld
from swarm_forage_env.scenarios import find_scenario

CROWD = {"arena.length": 0.8, "arena.width": 0.8, "area_distance": 0.59, "area_radius": 0.05}


def into_the_middle(world, rng):
    """Wheels that drive every robot into one clump, in which they push each other about."""
    x, y, theta = world.state.pose.T
    off = np.angle(np.exp(1j * (np.arctan2(-y, -x) - theta)))
    wheels = np.clip(np.stack([1.0 - off, 1.0 + off], axis=1), -1.0, 1.0)
    return wheels * world.scenario.robot.max_speed + 0.04 * rng.normal(size=wheels.shape)


@pytest.mark.parametrize(("n_robots", "before"), [(1, 40), (2, 7), (15, 0), (15, 1), (15, 30),
                                                  (15, 97), (15, 201), (15, 460)])  # fmt: skip
def test_robots_in_a_clump_go_on_bit_for_bit(go, n_robots, before):
    scenario = find_scenario("es1", {**CROWD, "n_robots": n_robots})
    used, copied = (ForagingWorld([scenario], [before], "rigid") for _ in range(2))
    rng, same_rng = np.random.default_rng(1), np.random.default_rng(1)
    for _ in range(before):
        go(used, into_the_middle(used, rng))
        go(copied, into_the_middle(copied, same_rng))
    copied._physics = pickle.loads(pickle.dumps(copied._physics))
    for _ in range(250):
        go(used, into_the_middle(used, rng))
        go(copied, into_the_middle(copied, same_rng))
        assert_array_equal(used.state.pose, copied.state.pose)
