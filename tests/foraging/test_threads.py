"""Threads: each runs its own worlds, and how many there are changes nothing."""

import pytest

from swarm_forage_env.errors import ConfigError

ENGINES = ("rigid", "kinematic")
BUSY = {"cruise_speed": 0.12, "area_distance": 0.7, "wheel_noise": 0.02}
"""Fast robots and near areas: round trips and exchanges within a minute."""
SEEDS = range(7)
TICKS = 400


@pytest.mark.parametrize("physics", ENGINES)
def test_the_same_bits_on_any_number_of_threads(running, bits, physics):
    found = []
    for threads in (1, 2, 3, 7, 20):
        loop = running("es1", SEEDS, physics, "dsgikf", threads, duration=60.0, **BUSY)
        loop.run(TICKS)
        found.append(bits(loop))
    assert all(each == found[0] for each in found)
    assert loop.world.robots["messages"].sum() > 0
    assert loop.world.robots["round_trips"].sum() > 0


def test_two_blocks_share_the_threads_of_a_pool(running, bits):
    blocks = [running("es1", SEEDS, "kinematic", threads=2) for _ in range(2)]
    for _ in range(20):
        for loop in blocks:
            loop.step()
    assert bits(blocks[0]) == bits(blocks[1])


@pytest.mark.parametrize("threads", [0, -1, 1.5, "2", True, None])
def test_a_number_of_threads_that_is_none_is_refused(running, threads):
    with pytest.raises(ConfigError, match="threads="):
        running("es1", [0], threads=threads)
