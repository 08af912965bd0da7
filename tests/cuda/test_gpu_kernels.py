"""How kernels of a GPU are compiled and what their launches are handed; none is needed."""

from types import SimpleNamespace

import numba
import numba.cuda
import numpy as np
import pytest

from swarm_forage_env.compiler import bind_grid, kernel
from tests.cuda.conftest import CAPABILITY
from tests.cuda.test_kept_code import of_kind

pytestmark = pytest.mark.cuda


def apply(numbers, terms, n):
    """A template: the free name is what is done with each number."""
    for k in range(n):
        numbers[k] = change(numbers[k]) + terms[0][k]


@kernel
def seventh(x):
    return x / 7.0


@kernel
def squared(x):
    return x * x


def test_a_loop_is_in_the_machine_code_once(ptx):
    numbers = np.ones(3)
    text = ptx(bind_grid(apply, {"change": seventh}), numbers, (numbers, 1), 3)
    assert text.count("div.rn.f64") == 1


@kernel
def positive(x):
    return max(-x, 0.0)


def test_the_larger_of_two_zeros_is_the_first_one_as_in_python(ptx):
    numbers = np.ones(3)
    text = ptx(bind_grid(apply, {"change": positive}), numbers, (numbers, 1), 3)
    assert "max.f64" not in text  # which takes the positive one


DFMA = 0x22B
"""The code of a fused product and sum of doubles in the machine code of CAPABILITY: 12 bits of 128.

`nvdisasm -hex` of CUDA 13 shows it.
"""


def test_machine_code_rounds_each_product_and_each_sum(monkeypatch):
    of_kind(CAPABILITY, monkeypatch)
    kinds = numba.float64[::1], numba.types.Tuple((numba.float64[::1], numba.int64)), numba.int64
    dispatcher = bind_grid(apply, {"change": squared}).dispatcher
    fused = numba.cuda.jit(dispatcher.py_func)  # as numba-cuda does by itself
    for each, is_fused in ((dispatcher, False), (fused, True)):
        code = each.compile(kinds)._codelibrary.get_cubin().code
        codes = {int.from_bytes(code[k : k + 2], "little") & 0xFFF for k in range(0, len(code), 16)}
        assert (DFMA in codes) == is_fused


def on_device(address, n):
    """What numba-cuda takes for an array of a GPU; there is none at its address."""
    layout = SimpleNamespace(strides_in_bytes=None, is_contiguous_c=True, is_contiguous_f=True)
    view = SimpleNamespace(size=n, dtype=np.dtype(float), ptr=address, shape=(n,), _layout=layout)
    return SimpleNamespace(
        __cuda_memory__=True, _strided_memory_view_shim=view, _numba_type_=numba.float64[::1]
    )


@pytest.fixture
def launched(monkeypatch):
    """What kernels were launched with instead, by numba-cuda or by the project."""
    import cuda.core
    from numba.cuda import codegen, dispatcher
    from numba.cuda.cudadrv import driver

    of_kind(CAPABILITY, monkeypatch)
    found = []

    def launch(stream, config, code, *words):
        found.append([getattr(each, "value", each) for each in words])

    for module in (cuda.core, dispatcher):
        monkeypatch.setattr(module, "launch", launch)
        monkeypatch.setattr(module, "LaunchConfig", lambda **how: how)
    monkeypatch.setattr(driver, "_to_core_stream", lambda stream: stream)
    monkeypatch.setattr(
        codegen.CUDACodeLibrary, "get_cufunc", lambda own: SimpleNamespace(kernel=own)
    )
    return found


def test_a_launch_is_handed_what_numba_hands_it(launched):
    a, b, c = on_device(4096, 5), on_device(8192, 7), on_device(1 << 40, 9)
    prepared = bind_grid(apply, {"change": seventh})
    calls = [(a, (b, 1), 5), (a, (b, 1), 6), (c, (b, 2), 5), (c, (a, 2), 5)]
    for arguments in calls:
        prepared[1, (3, 1), 0](*arguments)
    ours = launched.copy()
    launched.clear()
    for arguments in calls:
        types = tuple(map(prepared.dispatcher.typeof_pyval, arguments))
        prepared.dispatcher.compile(types).launch(arguments, 1, (3, 1), 0)
    assert ours == launched
    assert len({tuple(each) for each in ours}) == 4
