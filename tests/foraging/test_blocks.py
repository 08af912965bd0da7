"""A world in a block is the world alone, whatever was in its place before."""

import numpy as np

from swarm_forage_env.interface import KEEP, REPLACE
from tests.worlds import everything


def test_two_controllers_under_one_seed_meet_the_same_world(running):
    worlds = [everything(running("es1", [6], controller=name)) for name in ("nc", "dsgiff")]
    for name in worlds[0]:
        if not name.startswith("minds"):
            np.testing.assert_array_equal(worlds[0][name], worlds[1][name], err_msg=name)


def test_a_reset_leaves_what_a_learner_does_with_the_layers(running):
    loop = running("es1", [4, 5])
    loop.world.robots["action"]["motion"][0] = REPLACE
    loop.reset([6, 7])
    assert loop.world.robots["action"]["motion"].tolist() == [[REPLACE] * 10, [KEEP] * 10]
