"""Kernels that make no array are compiled without counts of who holds one.

Numba counts who holds an array at each view of it, as at the row of a table: a tenth of a tick. In
a kernel that is given all its arrays, the caller holds them, and nothing is to be counted.
"""

from collections.abc import Mapping
from contextlib import suppress
from typing import cast

import numba
from numba.core.compiler import Compiler, CompileResult
from numba.core.dispatcher import _FunctionCompiler  # type: ignore[attr-defined]
from numba.core.errors import NumbaError
from numba.core.ir import Expr

from swarm_forage_env.templates import FunctionT

VIEWS = "getitem", "static_getitem"
"""Steps of a function whose result is part of an array that is held anyway."""


def lean(function: FunctionT, options: Mapping[str, object]) -> FunctionT:
    """The function as numba compiles it, without counts wherever it can do without."""
    compiled = numba.njit(**options)(function)
    usual = compiled._compiler
    compiled._compiler = _LeanWhereItCan(
        function, usual.targetdescr, usual.targetoptions, usual.locals, usual.pipeline_class
    )
    return cast(FunctionT, compiled)


class Lean(Compiler):  # type: ignore[misc]
    """Numba's compiler, but its machine code does not count who holds an array."""

    def __init__(self, *parts: object) -> None:
        super().__init__(*parts)
        self.state.targetctx = self.state.targetctx.subtarget(enable_nrt=False)


class _LeanWhereItCan(_FunctionCompiler):  # type: ignore[misc]
    """Compiles with counts only what makes an array, hands one back or is handed one."""

    def _compile_core(self, *signature: object) -> CompileResult:
        options = self.targetdescr, self.targetoptions, self.locals
        with suppress(NumbaError):  # a function that makes one is refused
            result = _FunctionCompiler(self.py_func, *options, Lean)._compile_core(*signature)
            if not _is_handed_arrays(result):
                return result
        return super()._compile_core(*signature)


def _is_handed_arrays(result: CompileResult) -> bool:
    """Whether machine code returns an array, or calls what may return one."""
    steps = result.type_annotation.calltypes.items()
    called = (of for at, of in steps if isinstance(at, Expr) and at.op not in VIEWS)
    model = result.target_context.data_model_manager
    types = {each.return_type for each in (result.signature, *called)}
    return any(model[each].contains_nrt_meminfo() for each in types)
