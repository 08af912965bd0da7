"""Machine code of a GPU is kept on disk: linked for a named kind of GPU, and none is needed."""

from types import SimpleNamespace

import numpy as np
import pytest

from swarm_forage_env import compiler
from swarm_forage_env.compiler import _bound_grid, bind_grid, kernel
from swarm_forage_env.kernel_cache import cache_folder
from tests.cuda.conftest import CAPABILITY

pytestmark = pytest.mark.cuda


def apply(numbers):
    """A template: the free name is what is done with each number."""
    for k in range(lane(), numbers.shape[0], lanes()):
        numbers[k] = change(numbers[k])


@kernel
def double(x):
    return 2.0 * x


@kernel
def negate(x):
    return -x


def of_kind(capability, patch):
    """Let numba-cuda link kernels for a kind of GPU where it would load them too."""
    from numba.cuda import codegen, dispatcher

    gpu = SimpleNamespace(compute_capability=capability)
    patch.setattr(dispatcher, "get_current_device", lambda: gpu)
    patch.setattr(
        codegen, "devices", SimpleNamespace(get_context=lambda: SimpleNamespace(device=gpu))
    )
    patch.setattr(dispatcher._Kernel, "bind", lambda own: own._codelibrary.get_cubin())


def made(change):
    """The machine code of a composition, and whether it comes from the disk."""
    import numba

    compiled = bind_grid(apply, {"change": change}).dispatcher
    linked = compiled.compile((numba.typeof(np.ones(3)),))._codelibrary.get_cubin().code
    return linked, sum(compiled.stats.cache_hits.values())


@pytest.fixture
def fresh_cache(tmp_path, monkeypatch):
    """A folder for machine code in which there is none yet, and nothing is kept in memory."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    of_kind(CAPABILITY, monkeypatch)
    _bound_grid.cache_clear()
    return cache_folder()


def test_kept_code_is_that_of_its_composition_and_kind_of_gpu(fresh_cache, monkeypatch):
    found = []
    for change, capability in ((double, (9, 0)), (negate, (9, 0)), (double, (8, 0))) * 2:
        of_kind(capability, monkeypatch)
        _bound_grid.cache_clear()  # the second time the machine code comes from the disk
        found.append(made(change))
    linked, hits = zip(*found, strict=True)
    assert hits == (0, 0, 0, 1, 1, 1)
    assert linked[:3] == linked[3:]
    assert len(set(linked)) == 3


def test_kept_code_is_not_that_of_another_text(fresh_cache, monkeypatch):
    found = []
    for text in (compiler.as_on_cpu, compiler.as_on_cpu, lambda text: text):
        monkeypatch.setattr(compiler, "as_on_cpu", text)
        _bound_grid.cache_clear()
        found.append(made(double)[1])
    assert found == [0, 1, 0]


@pytest.mark.parametrize("ending", ["nbi", "nbc"])
def test_a_damaged_file_is_replaced(fresh_cache, ending):
    hits = []
    for moment in ("compiled", "damaged", "kept"):
        _bound_grid.cache_clear()
        hits.append(made(double)[1])
        if moment == "compiled":
            (file,) = fresh_cache.glob(f"*.{ending}")
            content = file.read_bytes()
            middle = len(content) // 2
            flipped = bytes([content[middle] ^ 1])
            file.write_bytes(content[:middle] + flipped + content[middle + 1 :])
    assert hits == [0, 0, 1]
