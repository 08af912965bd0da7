"""The swarm in one file goes through the poses of the core."""

import re
from pathlib import Path

import numpy as np
from numpy.testing import assert_array_equal

from swarm_forage_env import find_scenario
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.loop import Loop

SEED, TICKS = 8, 2000
"""Robots copy an estimate, blend two, get lost and make round trips."""


def test_the_swarm_in_one_file_goes_through_the_same_poses_bit_for_bit(example):
    tiny = example("tiny_forage")
    loop = Loop(find_scenario("es1"), find_controller("ssgikf"), [SEED], "kinematic")
    world = tiny.World(SEED)
    for k in range(TICKS):
        poses = np.column_stack((world.at.real, world.at.imag, world.heading))
        assert_array_equal(poses, loop.world.robots["pose"][0], f"tick {k}")
        loop.step()
        tiny.tick(world)
    assert world.round_trips.sum() > 0
    assert_array_equal(world.round_trips, loop.world.robots["round_trips"][0])


def test_it_names_files_that_there_are(example):
    tiny = example("tiny_forage")
    root = Path(tiny.__file__).parents[1]
    names = re.findall(r"[\w/]+\.py", tiny.__doc__)
    assert names
    assert [name for name in names if not (root / name).is_file()] == []
