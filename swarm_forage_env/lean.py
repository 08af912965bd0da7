"""Numba's compilation of kernels, without the steps that they do not need.

A kernel that receives all its arrays does no reference counting, which saves a tenth of a tick. A
kernel called by other kernels only is not optimised before it is linked into an entry point: a
controller compiles in 0.6 of the time, to the same machine code.
"""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import partial
from typing import cast

from numba.core.codegen import CPUCodeLibrary
from numba.core.compiler import Compiler, CompileResult
from numba.core.compiler_lock import global_compiler_lock
from numba.core.dispatcher import _FunctionCompiler  # type: ignore[attr-defined]
from numba.core.errors import NumbaError
from numba.core.ir import Expr
from numba.core.registry import CPUDispatcher
from numba.core.sigutils import normalize_signature

from swarm_forage_env.errors import ConfigError
from swarm_forage_env.templates import FunctionT

VIEWS = "getitem", "static_getitem"
"""Operations whose result is part of an array that the function holds anyway."""


def lean(function: FunctionT, options: Mapping[str, object]) -> FunctionT:
    """Return the function compiled by numba, without reference counting wherever possible."""
    return cast(FunctionT, _LeanDispatcher(function, {}, {"nopython": True, **options}))


class _LeanDispatcher(CPUDispatcher):  # type: ignore[misc]
    """Dispatcher that creates an entry point for Python only if Python calls the function."""

    def __init__(self, function: Callable[..., object], *options: object) -> None:
        super().__init__(function, *options)
        usual: _FunctionCompiler = self._compiler
        self._compiler: _LeanOrUsual = _LeanOrUsual(
            function, usual.targetdescr, usual.targetoptions, usual.locals, usual.pipeline_class
        )

    def get_call_template(self, args: Sequence[object], kws: Mapping[str, object]) -> object:
        """Compile for a kernel that calls this one; ConfigError for a wrong field or argument."""
        name = f"kernel {self.py_func.__module__}.{self.py_func.__qualname__}"
        try:
            self._compiler.pysig.bind(*args, **kws)
        except TypeError as error:
            raise ConfigError(f"{name}: is called with {len(args)} arguments: {error}") from None
        with global_compiler_lock:
            self._compiler.is_inner = True
            try:
                return super().get_call_template(args, kws)
            except KeyError as error:
                raise ConfigError(f"{name}: reads {error}, no field of its record") from None
            finally:
                self._compiler.is_inner = False

    def add_overload(self, result: CompileResult) -> None:
        """Add an overload; Python finds only those that it can call."""
        if isinstance(result.entry_point, _NoEntry):
            self.overloads[tuple(result.signature.args)] = result
        else:
            super().add_overload(result)

    def compile(self, signature: object) -> object:
        """Compile; an overload compiled for a kernel is compiled again for calls from Python."""
        arguments, return_type = normalize_signature(signature)
        with global_compiler_lock:  # only the thread that holds it may have set `is_inner`
            compiled = self.overloads.get(tuple(arguments))
            if not self._compiler.is_inner:
                if compiled and isinstance(compiled.entry_point, _NoEntry):
                    del self.overloads[tuple(arguments)]
                return super().compile(signature)
            if compiled is None:
                compiled = self._compiler.compile(arguments, return_type)
                self.add_overload(compiled)
            return compiled.entry_point


class _NoEntry:
    """Placeholder for the entry point of a function that Python does not call."""


class Inner(Compiler):  # type: ignore[misc]
    """Numba's compiler for functions linked into callers: no wrappers and no machine code."""

    def __init__(self, *parts: object) -> None:
        super().__init__(*parts)
        state = self.state
        state.flags = state.flags.copy()
        state.flags.no_cpython_wrapper = state.flags.no_cfunc_wrapper = True
        state.targetctx = state.targetctx.subtarget()
        state.targetctx.get_executable = lambda *_: _NoEntry()

    def compile_extra(self, function: Callable[..., object]) -> CompileResult:
        """Compile a function into a library that is linked, but never run itself."""
        library = self.state.targetctx.codegen().create_library(function.__qualname__)
        library._optimize_final_module = lambda: None
        library._finalize_final_module = partial(_finalize_unloaded, library)
        self.state.library = library
        return super().compile_extra(function)


def _finalize_unloaded(library: CPUCodeLibrary) -> None:
    library._finalize_dynamic_globals()
    library._finalized = True


class Lean(Compiler):  # type: ignore[misc]
    """Numba's compiler without reference counting of arrays."""

    def __init__(self, *parts: object) -> None:
        super().__init__(*parts)
        self.state.targetctx = self.state.targetctx.subtarget(enable_nrt=False)


class _LeanInner(Inner, Lean):
    """Compiler that combines `Inner` and `Lean`."""


class _LeanOrUsual(_FunctionCompiler):  # type: ignore[misc]
    """Counts references only in functions that create or return arrays, or get one from a call."""

    is_inner = False
    """Whether the function is compiled for a kernel, and not for Python."""

    def _compile_core(self, *signature: object) -> CompileResult:
        pipelines = (_LeanInner, Inner) if self.is_inner else (Lean, self.pipeline_class)
        options = self.targetdescr, self.targetoptions, self.locals
        fast, usual = (_FunctionCompiler(self.py_func, *options, each) for each in pipelines)
        with suppress(NumbaError):  # numba refuses a function that creates an array
            result = fast._compile_core(*signature)
            if not _is_handed_arrays(result):
                return result
        return usual._compile_core(*signature)


def _is_handed_arrays(result: CompileResult) -> bool:
    """Return whether machine code returns an array, or calls a function that may return one."""
    steps = result.type_annotation.calltypes.items()
    called = (of for at, of in steps if isinstance(at, Expr) and at.op not in VIEWS)
    model = result.target_context.data_model_manager
    types = {each.return_type for each in (result.signature, *called)}
    return any(model[each].contains_nrt_meminfo() for each in types)
