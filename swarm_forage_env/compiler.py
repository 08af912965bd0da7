"""The compiler of all kernels: its options, its cache and the cache key.

The key of numba's cache depends on one file, so that a caller would keep the old body of a callee
edited in another. Here the key is what machine code depends on: the bytecode and the constants of a
function and of all that it calls.
"""

import os
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import cache
from importlib.util import find_spec
from itertools import count
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any, Protocol, cast

import llvmlite
import numba
import numpy as np
from numba.core import bytecode, caching, config
from numba.core.compiler_lock import global_compiler_lock
from numba.core.dispatcher import Dispatcher

from swarm_forage_env.errors import ConfigError
from swarm_forage_env.extras import remedy
from swarm_forage_env.fingerprint import fingerprint
from swarm_forage_env.fingerprint import plain as plain
from swarm_forage_env.gpu_kernels import GPU_OPTIONS, PreparedKernel, as_on_cpu, compiled_for_gpu
from swarm_forage_env.kernel_cache import CheckedFiles, cache_folder, is_trusted, warn_once
from swarm_forage_env.lanes import ON_CPU, on_gpu
from swarm_forage_env.lean import Lean, lean
from swarm_forage_env.templates import (
    Bindings,
    Function,
    FunctionT,
    is_row_template,
    parts_of,
    with_parts,
)

_listeners: list[Callable[[str], None]] = []
"""Functions called with the name of each entry point that is about to be compiled."""

OPTIONS = {"error_model": "numpy", "nogil": True}
INLINED = {**OPTIONS, "forceinline": True}


def _make_names_unique() -> None:
    """Make the names of functions in machine code unique to this process.

    Numba numbers functions and records per process. If two processes cached functions of one name,
    the first would be called for both, even with records of another size.
    """
    start = int.from_bytes(os.urandom(6), "little")
    bytecode.FunctionIdentity._unique_ids = count(start)


_make_names_unique()
if sys.platform != "win32":  # Windows has no fork
    os.register_at_fork(after_in_child=_make_names_unique)
    os.register_at_fork(  # a fork waits for compilations in other threads, or the child would hang
        before=global_compiler_lock.acquire,
        after_in_parent=global_compiler_lock.release,
        after_in_child=global_compiler_lock.release,
    )


def kernel(function: FunctionT) -> FunctionT:
    """Compile a function for the kernels that call it."""
    return function if config.DISABLE_JIT else lean(function, OPTIONS)


def inlined(function: FunctionT) -> FunctionT:
    """Compile a function that is inlined into the kernels that call it."""
    return function if config.DISABLE_JIT else lean(function, INLINED)


def entry_point(function: FunctionT) -> FunctionT:
    """Compile a function that Python calls on structured arrays, and cache its machine code."""
    return _compiled(plain(function))


def bind(template: FunctionT, functions: Mapping[str, Function]) -> FunctionT:
    """Compile a template with its free names bound to these functions.

    Functions that the template does not name are ignored. Machine code is shared by all calls with
    the same template and functions, on disk also between processes.
    """
    return cast(FunctionT, _bound(template, parts_of(template, {**_lanes_on_cpu(), **functions})))


def bind_row(template: FunctionT, functions: Mapping[str, Function]) -> FunctionT:
    """Bind a row template, which is inlined into the CPU kernels that call it."""
    parts = parts_of(template, {**_lanes_on_cpu(), **functions})
    return cast(FunctionT, _bound_row(template, parts))


def typed_once(kernel: FunctionT) -> FunctionT:
    """Return the kernel for the argument types of its first call; later calls must use the same.

    Numba determines the types of all arguments in every call, which takes a microsecond for each
    array of records in a tuple.
    """
    if config.DISABLE_JIT:
        return kernel
    dispatcher = cast(Dispatcher, kernel)
    machine_code: list[Function] = []

    def call(*arguments: object) -> object:
        if not machine_code:
            signature = tuple(map(numba.typeof, arguments))
            dispatcher.compile(signature)
            machine_code.append(dispatcher.get_overload(signature))
        return machine_code[0](*arguments)

    return cast(FunctionT, call)


@cache
def _lanes_on_cpu() -> dict[str, Function]:
    return {name: inlined(each) for name, each in ON_CPU.items()}


@cache
def _lanes_on_gpu() -> dict[str, Function]:
    cuda = cast(ModuleType, _SimulatedThread()) if is_simulated() else gpu()
    return {name: inlined(each) for name, each in on_gpu(cuda).items()}


class _SimulatedThread:
    """Stand-in for `cuda` in the functions that a thread of numba's simulator runs."""

    def __getattr__(self, name: str) -> object:
        from numba.cuda.simulator.kernel import _get_kernel_context

        return getattr(_get_kernel_context(), name)


class GridKernel(Protocol):
    """A GPU kernel, called with a launch configuration: `kernel[launch](...)`."""

    def __getitem__(self, launch: tuple[object, ...], /) -> Callable[..., None]:
        """Return the kernel with this launch configuration."""


def bind_grid(template: Function, functions: Mapping[str, Function]) -> GridKernel:
    """Compile a template as `bind` does, for the lanes of a GPU; ConfigError without numba-cuda."""
    bound = _bound_grid(template, parts_of(template, {**_lanes_on_gpu(), **functions}))
    kernel: GridKernel = bound if is_simulated() else PreparedKernel(bound)
    return kernel


@cache
def _bound_grid(template: Function, parts: Bindings) -> Any:  # noqa: ANN401 numba-cuda's
    function = with_parts(template, parts, _bound_row)
    if is_simulated():
        return gpu().jit(_on_records(function))
    from numba.cuda.dispatcher import CUDACache, CUDACacheImpl

    compiled = gpu().jit(function, **GPU_OPTIONS)
    # the key of this cache also holds the versions of numba-cuda and CUDA, and the GPU
    compiled._cache = _LateCache(function, _checked(CUDACache, CUDACacheImpl))
    compiled.compile = compiled_for_gpu()(compiled.compile)
    return compiled


def gpu() -> ModuleType:
    """Return numba's module for GPUs; ConfigError if numba-cuda is missing."""
    if find_spec("numba_cuda") is None:
        raise ConfigError(f"device='cuda': needs numba-cuda; {remedy('numba_cuda')}")
    from numba import cuda

    return cast(ModuleType, cuda)


def is_simulated() -> bool:
    """Return whether numba's simulator replaces a GPU; its arrays are in the CPU's memory."""
    return bool(config.ENABLE_CUDASIM)


@cache
def _bound(template: Function, parts: Bindings) -> Function:
    for name, each in parts:
        is_plain = isinstance(each, FunctionType) and not is_row_template(each)
        if is_plain and not config.DISABLE_JIT:
            raise ConfigError(
                f"function {each.__module__}.{each.__qualname__}: the tick calls it as '{name}',"
                " but it is not compiled; decorate it with `swarm_forage_env.compiler.kernel`"
            )
    return _compiled(with_parts(template, parts, _bound_row))


@cache
def _bound_row(template: Function, parts: Bindings) -> Function:
    return inlined(with_parts(template, parts, _bound_row))


def _compiled(function: FunctionT) -> FunctionT:
    if config.DISABLE_JIT:
        return _on_records(function)
    compiled = lean(function, OPTIONS)
    make = _checked(caching.FunctionCache, caching.CompileResultCacheImpl)
    cast(Dispatcher, compiled)._cache = _LateCache(function, make)  # type: ignore[attr-defined]
    return compiled


def _on_records(function: FunctionT) -> FunctionT:
    """Return the Python function, called on records whose fields are attributes."""
    usable, warnings_off = _with_attributes, np.errstate

    def run(*arguments: object) -> object:
        with warnings_off(over="ignore"):  # whole numbers wrap around in machine code
            return function(*map(usable, arguments))

    return cast(FunctionT, run)


def _with_attributes(argument: object) -> object:
    if isinstance(argument, tuple):
        return tuple(map(_with_attributes, argument))
    simulated = getattr(argument, "_item", argument)  # an array in numba's simulator of a GPU
    if hasattr(simulated, "_ary"):
        return _with_attributes(simulated._ary)
    if isinstance(argument, np.ndarray) and argument.dtype.names is not None:
        return argument.view(np.recarray)
    if isinstance(argument, np.void) and argument.dtype.names is not None:
        return argument.view((np.record, argument.dtype))
    return argument


class _Locator:
    """Place of a kernel in numba's cache: one folder for all, under the kernel's fingerprint."""

    def __init__(self, function: Function) -> None:
        compilers = numba.__version__, llvmlite.__version__, sys.version_info[:2]
        # the last: names of older machine code could collide with those of other functions
        options = INLINED, Lean.__name__, config.BOUNDSCHECK, _make_names_unique.__name__
        of_gpu = GPU_OPTIONS, fingerprint(as_on_cpu)
        self._key = fingerprint(function, *compilers, *options, *of_gpu)

    @classmethod
    def from_function(cls, function: Function, file: str) -> "_Locator":
        return cls(function)

    def ensure_cache_path(self) -> None:
        cache_folder().parent.mkdir(parents=True, exist_ok=True)
        cache_folder().mkdir(mode=0o700, exist_ok=True)

    def get_cache_path(self) -> str:
        return str(cache_folder())

    def get_source_stamp(self) -> str:
        return self._key

    def get_disambiguator(self) -> str:
        return self._key


@cache
def _checked(usual: Any, usual_files: Any) -> Any:  # noqa: ANN401 numba's
    """Return numba's cache with checked files; if they cannot be used, code stays in memory."""

    class Files(usual_files):  # type: ignore[misc]
        _locator_classes = [_Locator]  # noqa: RUF012 numba's attribute

    class Cache(usual):  # type: ignore[misc]
        _impl_class = Files

        def __init__(self, function: Function) -> None:
            super().__init__(function)
            stamp = self._impl.locator.get_source_stamp()
            self._cache_file = CheckedFiles(self._cache_path, self._impl.filename_base, stamp)
            if not is_trusted(cache_folder()):
                self.disable()

        def load_overload(self, *signature: object) -> object:
            with suppress(OSError):
                return super().load_overload(*signature)
            return None

        def save_overload(self, *code: object) -> None:
            try:
                super().save_overload(*code)
            except OSError as error:
                warn_once(f"{cache_folder()} cannot be written ({error.strerror})")

    return Cache


class _LateCache:
    """Numba's cache of a kernel, created at its first call, when all its callees are defined."""

    def __init__(self, function: Function, make: Callable[[Function], Any]) -> None:
        self._function, self._make = function, make
        self._made: Any = None

    def __getattr__(self, name: str) -> object:
        if self._made is None:
            self._made = self._make(self._function)
            if not Path(self._made._cache_file._index_path).exists():
                announce()
                for tell in _listeners:
                    tell(self._function.__name__)
        return getattr(self._made, name)


@contextmanager
def report_compiling(tell: Callable[[str], None]) -> Iterator[None]:
    """Call a function with the name of each entry point that is about to be compiled."""
    _listeners.append(tell)
    try:
        yield
    finally:
        _listeners.remove(tell)


@cache
def announce() -> None:
    """Print, once, that kernels are about to be compiled."""
    sys.stderr.write(
        "swarm-forage: compiling the simulation, once for this version: about half a minute\n"
    )
