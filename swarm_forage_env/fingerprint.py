"""The fingerprint of a function: a hash of all that its machine code depends on."""

import hashlib
from collections.abc import Iterator
from enum import EnumMeta
from types import CodeType, FunctionType, ModuleType
from typing import cast

import numpy as np
from numba.core.types import ExternalFunction

from swarm_forage_env.templates import Function, FunctionT


def plain(function: FunctionT) -> FunctionT:
    """Return the Python function of a kernel; return anything else unchanged."""
    return cast(FunctionT, getattr(function, "py_func", function))


def fingerprint(function: Function, *around: object) -> str:
    """Return a hash of the bytecode and the constants of a function and of all that it calls.

    The hash includes values read from other modules and enumerations, closure variables and
    defaults. `around` is what else machine code depends on, such as the version of a compiler.
    """
    text = hashlib.sha256(repr(around).encode())
    for piece in _pieces(cast(FunctionType, plain(function)), set()):
        text.update(repr(piece).encode())
    return text.hexdigest()[:20]


def _pieces(function: FunctionType, seen: set[int]) -> Iterator[object]:
    """Yield what the machine code of a function depends on, in the order of its names."""
    if id(function) in seen:
        return
    seen.add(id(function))
    yield from _code(function.__code__, function.__doc__)
    names = tuple(_names(function.__code__))
    yield from _content(function.__defaults__, names, seen)
    around = zip(function.__code__.co_freevars, function.__closure__ or (), strict=True)
    named = {name: function.__globals__.get(name) for name in names}
    for name, value in {**named, **{name: cell.cell_contents for name, cell in around}}.items():
        yield name
        yield from _content(value, names, seen)


def _names(code: CodeType) -> Iterator[str]:
    yield from code.co_names
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _names(constant)


def _content(value: object, names: tuple[str, ...], seen: set[int]) -> Iterator[object]:
    """Yield what machine code takes from a value that a function with these names can read."""
    function = getattr(value, "py_func", getattr(value, "_defn", value))  # a kernel, an intrinsic
    if isinstance(function, FunctionType):
        yield from _pieces(function, seen)
    elif isinstance(value, tuple | list):
        yield type(value).__name__, len(value)
        for each in value:
            yield from _content(each, names, seen)
    elif isinstance(value, ModuleType | EnumMeta) and hash((id(value), names)) not in seen:
        seen.add(hash((id(value), names)))
        for name in (name for name in names if name in vars(value)):
            yield name
            yield from _content(getattr(value, name), names, seen)
    else:
        yield _constant(value)


def _constant(value: object) -> object:
    """Return a simple value as an object with an unambiguous `repr`; None for other values."""
    if isinstance(value, np.ndarray):
        return value.dtype.str, value.shape, value.tobytes()
    if isinstance(value, ExternalFunction):
        return value.symbol, str(value.sig)
    if isinstance(value, type):
        return value.__module__, value.__qualname__
    return value if isinstance(value, int | float | complex | str | np.generic | np.dtype) else None


def _code(code: CodeType, docstring: str | None) -> Iterator[object]:
    yield code.co_name, code.co_code, code.co_names, code.co_varnames[: code.co_argcount]
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _code(constant, None)
        elif docstring is None or constant != docstring:
            yield constant
