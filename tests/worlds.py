"""What holds for the worlds of every task: each is that world alone, whatever is done to others."""

import copy
import pickle

import numpy as np

from swarm_forage_env.loop import Loop
from tests.columns import columns


def everything(loop, worlds=slice(None)):
    """All that is true, sensed, believed and drawn in worlds of a running block, by name."""
    kinds = {
        "robots": loop.world.robots,
        "worlds": loop.world.worlds,
        "sightings": getattr(loop.world, "sightings", None),
        "minds": loop.controller.minds,
        "shared": getattr(loop.controller, "shared", None),
    }
    return {
        name: column
        for kind, records in kinds.items()
        if records is not None
        for name, column in columns(records[worlds], kind)
    }


def check_same_world(loop, world, other, other_world=0):
    """Assert that worlds of two running blocks are in the same state, but for their actions."""
    mine = everything(loop, slice(world, world + 1))
    theirs = everything(other, slice(other_world, other_world + 1))
    assert mine.keys() == theirs.keys()
    states = [name for name in mine if not name.startswith("robots.action.")]
    different = [name for name in states if not _equal(mine[name], theirs[name])]
    assert not different, f"{different} after {loop.world.worlds['ticks'][world]} ticks"


def _equal(one, other):
    """Equal, but for slots that only one of the blocks has room for."""
    common = tuple(slice(min(sizes)) for sizes in zip(one.shape, other.shape, strict=True))
    return np.array_equal(one[common], other[common])


def check_each_is_itself(scenarios, controllers, seeds, physics=None, ticks=200):
    """Assert that each world of a block is that world alone, bit for bit; a block that has run.

    It is so on threads, in a copy, from a snapshot on, and where it or another one was reset.
    Scenarios and controllers are one for all worlds or one for each.
    """

    def alone(world, seed):
        own = (each[world] if isinstance(each, list) else each for each in (scenarios, controllers))
        return Loop(*own, [seed], physics)

    used = Loop(scenarios, controllers, [seed + 100 for seed in seeds], physics)
    used.run(ticks)
    used.reset(seeds)
    block = Loop(scenarios, controllers, seeds, physics, threads=2)
    expected = [alone(world, seed) for world, seed in enumerate(seeds)]
    run(ticks, block, used, *expected)
    kept, copies = block.snapshot(), [copy.deepcopy(block), pickle.loads(pickle.dumps(block))]
    block.reset([50], worlds=[0])
    expected.append(alone(0, 50))
    run(ticks, block, used, *copies, *expected)
    for world, loop in enumerate(expected[:-1]):
        for other in (used, *copies, *([block] if world else [])):
            check_same_world(other, world, loop)
    check_same_world(block, 0, expected[-1])
    block.restore(kept)
    run(ticks, block)
    for world, loop in enumerate(expected[:-1]):
        check_same_world(block, world, loop)
    return block


def run(n_ticks, *loops):
    """Run loops one after the other for so many ticks."""
    for loop in loops:
        loop.run(n_ticks)
