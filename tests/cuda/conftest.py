"""Tests of the kernels of a GPU: what they need, and the compositions that they are tested with."""

import importlib.util
from types import SimpleNamespace

import numpy as np
import pytest

import baselines.controllers  # noqa: F401 controllers, by name
import training.controllers  # noqa: F401 learned layers, by name
from swarm_forage_env.gpu_kernels import compiled_for_gpu

ON_GRID = (
    "nc", "ssgikf", "dsgikf", "ssgiff", "dsgiff", "dsgiff-penalised", "dsgiff-frequent",
    "ssgikf-sceptical", "sikf", "covariance", "learned-weighting", "learned-motion", "learned-both",
    "learned-robust", "learned-sceptical",
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


@pytest.fixture(autouse=True)
def _gpu(request):
    """Skip what needs a GPU where there is none, and say why."""
    if request.node.get_closest_marker("gpu"):
        from numba import cuda

        if not cuda.is_available():
            pytest.skip("no NVIDIA GPU with its driver found")


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
        with compiled_for_gpu():
            text, result = cuda.compile_ptx(kernel.dispatcher.py_func, types, cc=CAPABILITY)
        assert result == numba.types.none
        return text

    return compiled


def contiguous(records):
    """Records as they lie on a GPU."""
    return np.ascontiguousarray(records)
