"""Functions of Chipmunk, the library below pymunk, that compiled functions call.

Machine code names them, so that it can be kept; each process says where they lie. They take
addresses and numbers alone: how a vector is handed over differs from platform to platform.
"""

import ctypes
from collections.abc import Callable, Mapping
from typing import Any

from llvmlite.binding import add_symbol
from numba.core import config
from numba.core.types import ExternalFunction, Number, float64, intp, void
from pymunk._chipmunk import ffi, lib

PLAIN: Mapping[Number, type[Any]] = {intp: ctypes.c_size_t, float64: ctypes.c_double}
"""Types of arguments with the compiler switched off."""


def address_of(pointer: object) -> int:
    """Where what pymunk points to lies."""
    return int(ffi.cast("uintptr_t", pointer))


def _function(name: str, *arguments: Number) -> Callable[..., None]:
    address = address_of(ffi.addressof(lib, name))
    if config.DISABLE_JIT:
        return ctypes.CFUNCTYPE(None, *(PLAIN[each] for each in arguments))(address)
    add_symbol(name, address)
    return ExternalFunction(name, void(*arguments))


step_space = _function("cpSpaceStep", intp, float64)
"""Move the bodies of a space (its address) by a time [s]."""

each_body = _function("cpSpaceEachBody", intp, intp, intp)
"""Call a function (its address) with each body of a space, and with an argument (its address)."""
