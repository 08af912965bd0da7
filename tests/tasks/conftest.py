"""A task of somebody else's, found by its entry point as an installed package would be."""

import sys
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path

import pytest

import baselines.controllers  # noqa: F401 enters the controllers
from baselines.controller import REGISTRIES
from swarm_forage_env import registry
from swarm_forage_env.registry import CONTROLLERS, PLUGIN_GROUP, SCENARIOS
from swarm_forage_env.task import TASKS

collect_ignore = ["patrol", "coverage_of_floor.py"]


@pytest.fixture(scope="module")
def registered_here():
    """What is registered while a module of tests runs is forgotten after it."""
    with pytest.MonkeyPatch.context() as patch:
        for each in (TASKS, SCENARIOS, CONTROLLERS, *REGISTRIES.values()):
            list(each)
            patch.setattr(each, "_parts", dict(each._parts))
        yield patch


@pytest.fixture(scope="module")
def patrol(registered_here):
    """The package `patrol` as a plug-in: imported when one of its names is asked for."""
    points = [*entry_points(group=PLUGIN_GROUP), EntryPoint("patrol", "patrol", PLUGIN_GROUP)]
    registered_here.syspath_prepend(str(Path(__file__).parent))
    registered_here.setattr(registry, "entry_points", lambda group: points)
    yield
    for name in [name for name in sys.modules if name.partition(".")[0] == "patrol"]:
        del sys.modules[name]
