"""A world in a block is the world alone, whatever was in its place before."""

import numpy as np
import pytest

from swarm_forage_env.interface import KEEP, REPLACE
from swarm_forage_env.registry import CONTROLLERS
from swarm_forage_env.scenarios import find_scenario
from tests.worlds import check_each_is_itself, everything

ENGINES = ("rigid", "kinematic")


@pytest.mark.parametrize("physics", ENGINES)
@pytest.mark.parametrize("scenario", ["es1", "es2", "real", "ants2008"])
def test_a_world_in_a_block_is_the_world_alone(scenario, physics):
    scenario, controller = find_scenario(scenario), CONTROLLERS["ssgiff"]
    block = check_each_is_itself(scenario, controller, [11, 5, 8], physics, 500)
    assert block.world.state.messages.sum() > 0


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
