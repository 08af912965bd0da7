"""A world in a block is the world alone, whatever was in its place before."""

import numpy as np
import pytest

from swarm_forage_env.interface import KEEP, REPLACE
from tests.foraging.conftest import CROWD, into_the_middle

ENGINES = ("rigid", "kinematic")


@pytest.mark.parametrize("physics", ENGINES)
@pytest.mark.parametrize(
    ("scenario", "place", "ticks"),
    [("es1", 0, 1500), ("es2", 1, 900), ("real", 2, 1500), ("ants2008", 1, 900)],
)
def test_a_world_in_a_block_is_the_world_alone(running, same, scenario, place, ticks, physics):
    seeds = [11, 5, 8]
    block = running(scenario, seeds, physics)
    alone = running(scenario, [seeds[place]], physics)
    for tick in range(ticks):
        block.step()
        alone.step()
        if tick % 100 == 0:
            same(block, place, alone)
    same(block, place, alone)
    assert block.world.state.messages.sum() > 0

    block.reset([5, 8, 21])  # other seeds, at other places
    fresh = running(scenario, [5, 8, 21][place : place + 1], physics)
    same(block, place, fresh)
    for _ in range(200):
        block.step()
        fresh.step()
    same(block, place, fresh)


@pytest.mark.parametrize("physics", ENGINES)
def test_a_world_forgets_its_contacts_when_it_is_reset(running, go, physics):
    used = running("es1", [4], physics).world
    for _ in range(150):
        go(used, into_the_middle(used))
    used.reset([7])
    fresh = running("es1", [7], physics).world
    for _ in range(150):
        go(used, into_the_middle(used))
        go(fresh, into_the_middle(fresh))
    np.testing.assert_array_equal(used.state.pose, fresh.state.pose)


@pytest.mark.parametrize("physics", ENGINES)
def test_a_crowded_world_in_a_block_is_the_world_alone(running, go, physics):
    block = running("es1", [3, 1, 2], physics, **CROWD).world
    alone = running("es1", [1], physics, **CROWD).world
    for _ in range(200):
        go(block, into_the_middle(block))
        go(alone, into_the_middle(alone))
    assert block.robots[1].tobytes() == alone.robots[0].tobytes()


def test_two_controllers_under_one_seed_meet_the_same_world(running, everything):
    worlds = [everything(running("es1", [6], controller=name)) for name in ("nc", "dsgiff")]
    for name in worlds[0]:
        if not name.startswith("minds"):
            np.testing.assert_array_equal(worlds[0][name], worlds[1][name], err_msg=name)


def test_a_reset_leaves_what_a_learner_does_with_the_layers(running):
    loop = running("es1", [4, 5])
    loop.world.robots["action"]["motion"][0] = REPLACE
    loop.reset([6, 7])
    assert loop.world.robots["action"]["motion"].tolist() == [[REPLACE] * 10, [KEEP] * 10]
