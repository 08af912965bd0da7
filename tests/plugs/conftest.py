"""The examples, loaded from their files; what a test needs that is not installed."""

import importlib.util
import sys
from pathlib import Path

import pytest

import baselines.controllers  # noqa: F401 the controllers, also where no package is installed
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.loop import Loop

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
NEEDS = {"ray": ("ray",), "rllib": ("ray",), "torchrl": ("torchrl", "benchmarl")}
"""What the tests of a marker need; `make test-<marker>` makes an environment that has it."""


@pytest.fixture(autouse=True)
def _needs(request):
    """Skip a test whose packages are missing; fail it where its marker was asked for by name."""
    for marker, packages in NEEDS.items():
        missing = [name for name in packages if importlib.util.find_spec(name) is None]
        if missing and request.node.get_closest_marker(marker):
            complain = pytest.fail if request.config.option.markexpr == marker else pytest.skip
            complain(f"{', '.join(missing)} not installed: run `make test-{marker}`")


@pytest.fixture
def one_thread():
    """Torch on one thread, and as it was found after the test."""
    import torch

    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(threads)
    torch.use_deterministic_algorithms(False)


@pytest.fixture
def example(monkeypatch):
    """A function that loads an example by name, as running its file does."""

    def load(name):
        spec = importlib.util.spec_from_file_location(name, EXAMPLES / f"{name}.py")
        module = importlib.util.module_from_spec(spec)
        monkeypatch.setitem(sys.modules, name, module)
        spec.loader.exec_module(module)
        return module

    return load


@pytest.fixture
def evaluated():
    """A function that runs a controller by name, as `evaluate` does: where its robots get to."""

    def ran(name, scenario, seed, ticks):
        loop = Loop(scenario, find_controller(name), [seed], "kinematic")
        loop.run(ticks)
        return loop.world.robots["pose"]

    return ran


@pytest.fixture
def small():
    """Few robots for a short time, on the quick engine."""
    return {"physics": "kinematic", "task.n_robots": 4}
