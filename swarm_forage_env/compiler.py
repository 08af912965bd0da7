"""One compiler for all kernels: options, cache and its key stand here and nowhere else.

Three decorators. `kernel` compiles a function that other kernels call, `inlined` one that becomes
part of them, and `entry_point` one that Python calls, whose machine code is kept on disk. `bind`
makes an entry point from a template whose free names are the functions of chosen parts, and
`bind_grid` makes the same functions run on a GPU.

Numba keys its cache on one file, so that a caller would keep the old body of a callee edited in
another. Here the key is what the machine code depends on: the bytecode and the constants of a
function and of all that it calls. An edit of a comment or a docstring changes no key.
"""

import os
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import cache, partial
from importlib.util import find_spec
from itertools import count
from pathlib import Path
from threading import Lock
from types import FunctionType
from typing import Any, TypeVar, cast

import llvmlite
import numba
import numpy as np
from numba.core import bytecode, caching, config
from numba.core.compiler_lock import global_compiler_lock

from swarm_forage_env.errors import ConfigError
from swarm_forage_env.extras import remedy
from swarm_forage_env.fingerprint import fingerprint
from swarm_forage_env.kernel_cache import CheckedFiles, cache_folder, is_trusted, tell_once
from swarm_forage_env.lanes import ON_CPU, on_gpu
from swarm_forage_env.lean import Lean, lean
from swarm_forage_env.templates import Parts, is_row_template, parts_of, with_parts

FunctionT = TypeVar("FunctionT")

_listeners: list[Callable[[str], None]] = []
"""Who is told of each entry point that is about to be compiled."""

_SWITCH = Lock()
"""Held while numba's warning of few blocks, or its fusing of operations, is switched off."""

OPTIONS: dict[str, Any] = {"error_model": "numpy", "nogil": True}
INLINED: dict[str, Any] = {**OPTIONS, "forceinline": True}


def _name_functions_anew() -> None:
    """Let names of functions in machine code be of this process alone.

    Numba names a function by its types and a number, and records among these by a number too,
    which it counts in each process. Where kept machine code of two processes is loaded, the
    second of two functions of one name is dropped and the first is called, be it for records of
    another size.
    """
    start = int.from_bytes(os.urandom(6), "little")
    bytecode.FunctionIdentity._unique_ids = count(start)


_name_functions_anew()
os.register_at_fork(after_in_child=_name_functions_anew)
os.register_at_fork(  # a fork amid a compilation of another thread's waits: its child would hang
    before=global_compiler_lock.acquire,
    after_in_parent=global_compiler_lock.release,
    after_in_child=global_compiler_lock.release,
)


def kernel(function: FunctionT) -> FunctionT:
    """Compile a function for the kernels that call it."""
    if config.DISABLE_JIT:
        return function
    return cast(FunctionT, lean(cast(Any, function), OPTIONS))


def inlined(function: FunctionT) -> FunctionT:
    """Compile a function into the kernels that call it, as the body of a loop over robots."""
    if config.DISABLE_JIT:
        return function
    return cast(FunctionT, lean(cast(Any, function), INLINED))


def entry_point(function: FunctionT) -> FunctionT:
    """Compile a function that Python calls on structured arrays; its machine code is kept."""
    return cast(FunctionT, _compiled(cast(Any, plain(function))))


def plain(function: FunctionT) -> FunctionT:
    """The function that a kernel was made of, for a use that is not worth compiling."""
    return cast(FunctionT, getattr(cast(Any, function), "py_func", function))


def bind(template: Callable[..., Any], functions: Mapping[str, Callable[..., Any]]) -> Any:  # noqa: ANN401 a kernel
    """Compile a template with functions of chosen parts in the place of its free names.

    Functions that the template does not name are let be. The same template and functions, in
    another process too, share their machine code on disk.
    """
    return _bound(template, parts_of(template, {**_lanes_on_cpu(), **functions}))


def bind_row(template: Callable[..., Any], functions: Mapping[str, Callable[..., Any]]) -> Any:  # noqa: ANN401 a kernel
    """Bind a template of one row, which becomes part of the kernels of a CPU that call it.

    A function without free names is returned as it is.
    """
    if not is_row_template(template):
        return template
    return _bound_row(template, parts_of(template, {**_lanes_on_cpu(), **functions}))


def typed_once(kernel: Callable[..., Any]) -> Callable[..., Any]:
    """The kernel for arguments of the types of its first call: later ones must have the same.

    Numba looks at the types of all arguments in every call, which takes it a microsecond for each
    array of records in a tuple.
    """
    if config.DISABLE_JIT:
        return kernel
    machine_code: list[Callable[..., Any]] = []

    def call(*arguments: Any) -> Any:  # noqa: ANN401 whatever the kernel takes
        if not machine_code:
            signature = tuple(map(numba.typeof, arguments))
            cast(Any, kernel).compile(signature)
            machine_code.append(cast(Any, kernel).get_overload(signature))
        return machine_code[0](*arguments)

    return call


@cache
def _lanes_on_cpu() -> dict[str, Callable[..., Any]]:
    return {name: inlined(each) for name, each in ON_CPU.items()}


@cache
def _lanes_on_gpu() -> dict[str, Callable[..., Any]]:
    functions = on_gpu(_SimulatedThread() if is_simulated() else gpu())
    return {name: inlined(each) for name, each in functions.items()}


class _SimulatedThread:
    """What `cuda` is to a thread of numba's simulator, in any function that it runs."""

    def __getattr__(self, name: str) -> Any:  # noqa: ANN401 as of numba's module for GPUs
        """An attribute of `cuda`, as the kernel that is running has it."""
        from numba.cuda.simulator.kernel import _get_kernel_context

        return getattr(_get_kernel_context(), name)


def bind_grid(template: Callable[..., Any], functions: Mapping[str, Callable[..., Any]]) -> Any:  # noqa: ANN401 a kernel
    """Compile a template for a GPU, whose threads are the lanes of its worlds.

    The same template and functions share their machine code within a process. ConfigError where
    numba-cuda is missing.
    """
    return _bound_grid(template, parts_of(template, {**_lanes_on_gpu(), **functions}))


@cache
def _bound_grid(template: Callable[..., Any], parts: Parts) -> Any:  # noqa: ANN401 a kernel
    function = _function_of(template, parts)
    if config.ENABLE_CUDASIM:
        return gpu().jit(_plain(function))
    compiled = gpu().jit(function)
    compiled.compile = rounding_each()(compiled.compile)
    compiled.configure = _without_size_warning(compiled.configure)
    return compiled


def _without_size_warning(configure: Callable[..., Any]) -> Callable[..., Any]:
    """A kernel's method that sizes its launch, silent on few blocks: so many worlds there are.

    Numba warns of them by one switch for all kernels of the process, the user's own among them.
    """

    def configured(*on: Any) -> Any:  # noqa: ANN401 numba's
        with _SWITCH:
            warns = config.CUDA_LOW_OCCUPANCY_WARNINGS
            config.CUDA_LOW_OCCUPANCY_WARNINGS = 0
            try:
                return configure(*on)
            finally:
                config.CUDA_LOW_OCCUPANCY_WARNINGS = warns

    return configured


@contextmanager
def rounding_each() -> Iterator[None]:
    """What is compiled for a GPU meanwhile rounds each product and each sum, as a CPU does.

    Numba's decorator has no option for this, but what it calls to make PTX has.
    """
    from numba.cuda.cudadrv import nvvm

    with _SWITCH:
        usual = nvvm.compile_ir
        nvvm.compile_ir = partial(usual, fma=False)
        try:
            yield
        finally:
            nvvm.compile_ir = usual


def gpu() -> Any:  # noqa: ANN401 numba's module for GPUs
    """What moves arrays to a GPU and back; ConfigError where numba-cuda is missing."""
    if find_spec("numba_cuda") is None:
        raise ConfigError(f"device='cuda': needs numba-cuda; {remedy('numba_cuda')}")
    from numba import cuda

    return cuda


def is_simulated() -> bool:
    """Whether numba's simulator is in the place of a GPU: its arrays lie in the CPU's memory."""
    return bool(config.ENABLE_CUDASIM)


@cache
def _bound(template: Callable[..., Any], parts: Parts) -> Any:  # noqa: ANN401 a kernel
    return _compiled(_function_of(template, parts))


@cache
def _bound_row(template: Callable[..., Any], parts: Parts) -> Any:  # noqa: ANN401 a kernel
    return inlined(_function_of(template, parts))


def _function_of(template: Callable[..., Any], parts: Parts) -> Callable[..., Any]:
    """A template whose free names are these parts."""
    return with_parts(template, parts, _bound_row)


def _compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """The kernel of a function, whose machine code is kept on disk."""
    if config.DISABLE_JIT:
        return _plain(function)
    compiled = lean(function, OPTIONS)
    compiled._cache = _LateCache(function)
    return cast(Callable[..., Any], compiled)


def _plain(function: Callable[..., Any]) -> FunctionType:
    """The function on records that have attributes in Python too."""

    usable, warnings_off = _with_attributes, np.errstate

    def run(*arguments: Any) -> Any:  # noqa: ANN401 whatever the kernel takes
        with warnings_off(over="ignore"):  # whole numbers wrap around in machine code
            return function(*map(usable, arguments))

    return cast(FunctionType, run)


def _with_attributes(argument: Any) -> Any:  # noqa: ANN401 whatever was passed
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
    """Where numba keeps a kernel: one folder for all, under the kernel's fingerprint."""

    def __init__(self, function: Callable[..., Any]) -> None:
        """Of one kernel."""
        compilers = numba.__version__, llvmlite.__version__, sys.version_info[:2]
        # the last: machine code of before could be called in the place of another function
        options = INLINED, Lean.__name__, config.BOUNDSCHECK, _name_functions_anew.__name__
        self._key = fingerprint(function, *compilers, *options)

    @classmethod
    def from_function(cls, function: Callable[..., Any], file: str) -> "_Locator":
        """The locator of a function, wherever its file lies."""
        return cls(function)

    def ensure_cache_path(self) -> None:
        """Make the folder, which only the user may write."""
        cache_folder().parent.mkdir(parents=True, exist_ok=True)
        cache_folder().mkdir(mode=0o700, exist_ok=True)

    def get_cache_path(self) -> str:
        """The folder."""
        return str(cache_folder())

    def get_source_stamp(self) -> str:
        """What machine code must have been made from to be used again."""
        return self._key

    def get_disambiguator(self) -> str:
        """The part of the file's name that tells kernels of one name apart."""
        return self._key


class _CacheOfKernels(caching.CompileResultCacheImpl):  # type: ignore[misc]
    _locator_classes = [_Locator]  # noqa: RUF012 numba's attribute


class _KernelCache(caching.FunctionCache):  # type: ignore[misc]
    """Numba's cache; where no file can be read or written, kernels are compiled in memory."""

    _impl_class = _CacheOfKernels

    def __init__(self, function: Callable[..., Any]) -> None:
        """Of one kernel."""
        super().__init__(function)
        stamp = self._impl.locator.get_source_stamp()
        self._cache_file = CheckedFiles(self._cache_path, self._impl.filename_base, stamp)
        if not is_trusted(cache_folder()):
            self.disable()

    def load_overload(self, *signature: Any) -> Any:  # noqa: ANN401 numba's
        """The machine code for a signature, None if it is not kept."""
        with suppress(OSError):
            return super().load_overload(*signature)
        return None

    def save_overload(self, *code: Any) -> None:  # noqa: ANN401 numba's
        """Keep the machine code for a signature; where that fails, the user is told once."""
        try:
            super().save_overload(*code)
        except OSError as error:
            tell_once(f"{cache_folder()} cannot be written ({error.strerror})")


class _LateCache:
    """Numba's cache of a kernel, made at the first call, when all that it calls is defined."""

    def __init__(self, function: Callable[..., Any]) -> None:
        """Of one kernel."""
        self._function = function
        self._made: Any = None

    def __getattr__(self, name: str) -> Any:  # noqa: ANN401 numba's
        """An attribute of numba's own cache."""
        if self._made is None:
            self._made = _KernelCache(self._function)
            if not Path(self._made._cache_file._index_path).exists():
                announce()
                for tell in _listeners:
                    tell(self._function.__name__)
        return getattr(self._made, name)


@contextmanager
def compiling_told(tell: Callable[[str], None]) -> Iterator[None]:
    """Tell the name of each entry point that is about to be compiled."""
    _listeners.append(tell)
    try:
        yield
    finally:
        _listeners.remove(tell)


@cache
def announce() -> None:
    """Tell the user, once, that kernels are about to be compiled."""
    sys.stderr.write("swarm-forage: compiling, once for this version: about a minute\n")
