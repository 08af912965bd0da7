"""Tests of the kernels of a GPU: what they need, and the compositions that they are tested with."""

import importlib.util
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import baselines.controllers  # noqa: F401 controllers, by name
import training.controllers  # noqa: F401 learned layers, by name
from swarm_forage_env.compiler import rounding_each

ON_GRID = (
    "nc", "ssgikf", "dsgikf", "ssgiff", "dsgiff", "dsgiff-penalised", "dsgiff-frequent",
    "ssgikf-sceptical", "sikf", "covariance", "learned-weighting", "learned-motion", "learned-both",
    "learned-sceptical",
)  # fmt: skip
"""The named controllers that run on a GPU."""

COMPILED = (
    "nc", "ssgiff", "ssgikf-sceptical", "sikf", "covariance", "learned-both", "learned-sceptical",
)  # fmt: skip
"""Controllers among which every function of those occurs; they differ in more than numbers."""

CAPABILITY = 9, 0
"""The GPU that is compiled for: NVIDIA H100 and H200."""


def pytest_collection_modifyitems(config, items):
    """Skip what needs numba-cuda where it is missing; fail where these tests were asked for."""
    if importlib.util.find_spec("numba_cuda") is None:
        how = pytest.fail if "cuda" in config.option.markexpr else None
        for item in items:
            if item.path.parent.name == "cuda":
                if how:
                    how("numba-cuda is not installed: run `make test-cuda`")
                item.add_marker(pytest.mark.skip(reason="numba-cuda missing: `make test-cuda`"))


@pytest.fixture
def ptx(monkeypatch):
    """The PTX of a kernel of the grid for these arguments; no GPU is asked."""
    import numba
    from numba import cuda
    from numba.cuda import dispatcher

    gpu = SimpleNamespace(compute_capability=CAPABILITY)
    monkeypatch.setattr(dispatcher, "get_current_device", lambda: gpu)

    def compiled(kernel, *arguments):
        types = tuple(map(numba.typeof, arguments))
        with rounding_each():
            text, result = cuda.compile_ptx(kernel.py_func, types, cc=CAPABILITY)
        assert result == numba.types.none
        return text

    return compiled


def widened(loop, n_worlds):
    """What a GPU asks of a loop of so many worlds, made from a loop of one; to be reset first.

    A million worlds that a CPU makes take gigabytes of its memory.
    """

    def wide(records):
        return np.repeat(np.ascontiguousarray(records), n_worlds, axis=0)

    layers, world = loop.controller.compiled, loop.world
    layers = replace(layers, arrays=tuple(map(wide, layers.arrays)))
    arrays = tuple(map(wide, world.arrays))
    many = SimpleNamespace(
        arrays=arrays, robots=arrays[0], functions=world.functions, modes=wide(world.modes),
        trouble=np.zeros(n_worlds + 1, np.int64), n_worlds=n_worlds,
        scenarios=world.scenarios * n_worlds,
    )  # fmt: skip
    controller = SimpleNamespace(compiled=layers, check_on_gpu=lambda: None)
    return SimpleNamespace(task=loop.task, physics=loop.physics, world=many, controller=controller)


def contiguous(records):
    """Records as they lie on a GPU."""
    return np.ascontiguousarray(records)
