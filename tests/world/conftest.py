"""Fixtures of the world's tests: running swarms, and a look at all their arrays."""

from dataclasses import fields

import numpy as np
import pytest

import baselines.recipes  # noqa: F401 enters the controllers
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.interface import WORDS, Command
from swarm_forage_env.loop import ControlLoop
from swarm_forage_env.scenarios import find_scenario


@pytest.fixture
def running():
    """A block of worlds under a controller."""

    def start(scenario, seeds, physics="rigid", controller="ssgiff", **overrides):
        scenario = find_scenario(scenario, overrides)
        return ControlLoop(scenario, find_controller(controller), seeds, physics)

    return start


@pytest.fixture
def command():
    """A command to every robot of a world: wheels [m/s], and what to say."""

    def tell(world, wheels=0.0, speaking=False, words=0.0, lost=False, known=False):
        rows = world.rows
        return Command(
            wheels=np.broadcast_to(np.asarray(wheels, float), (rows, 2)).copy(),
            words=np.full((rows, WORDS), words, np.float32),
            speaking=np.full(rows, speaking),
            lost=np.full(rows, lost),
            known=np.full((rows, 2), known),
        )

    return tell


def arrays_of(thing, name=""):
    """Every array in a structure of arrays, by name."""
    if isinstance(thing, np.ndarray):
        yield name, thing
    else:
        for field in fields(thing):
            yield from arrays_of(getattr(thing, field.name), f"{name}.{field.name}")


@pytest.fixture
def everything():
    """All that is true, sensed, believed and drawn in a running block of worlds, by name."""

    def look(loop):
        found = dict(arrays_of(loop.world.state, "state"))
        found |= dict(arrays_of(loop.world.feedback, "feedback"))
        estimator = loop.controller.estimator
        found |= dict(arrays_of(estimator.beliefs, "beliefs"))
        found |= dict(arrays_of(estimator.encounter, "encounter"))
        found |= dict(arrays_of(estimator.situation, "situation"))
        found |= {f"streams.{cause.name}": words for cause, words in loop.world.streams.items()}
        return found

    return look


@pytest.fixture
def same(everything):
    """Assert that worlds of two running blocks are in the same state, bit for bit."""

    def check(loop, world, other, other_world=0):
        mine, theirs = everything(loop), everything(other)
        assert mine.keys() == theirs.keys()
        different = [
            name
            for name in mine
            if not np.array_equal(
                rows_of(mine[name], loop, world), rows_of(theirs[name], other, other_world)
            )
        ]
        assert not different, f"after {loop.world.state.ticks[world]} ticks"

    def rows_of(array, loop, world):
        per_world = len(array) // loop.world.n_worlds
        return array[world * per_world : (world + 1) * per_world]

    return check
