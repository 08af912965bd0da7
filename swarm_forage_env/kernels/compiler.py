"""One compiler for all kernels: options, cache and its key stand here and nowhere else."""

import hashlib
import os
import sys
from functools import cache
from inspect import getfile
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
import numpy as np
from numba.core import config

FunctionT = TypeVar("FunctionT")


def kernel(function: FunctionT) -> FunctionT:
    """Compile a function, and keep the machine code until any kernel file changes.

    Numba keys its cache on one file, so that a caller keeps the old body of a callee
    edited in another. Here the key is the text of all files in the folder of the kernels
    and in the folder of the function.
    """
    if config.DISABLE_JIT:  # whole numbers wrap around in machine code, and warn in NumPy
        plain: Any = np.errstate(over="ignore")(cast(Any, function))
        return cast(FunctionT, plain)
    file = Path(getfile(cast(Any, function)))
    before = config.CACHE_DIR
    config.CACHE_DIR = str(cache_folder(file.parent))
    try:
        compiled: Any = numba.njit(cache=True, error_model="numpy")(cast(Any, function))
        return cast(FunctionT, compiled)
    finally:
        config.CACHE_DIR = before


_missing: list[Path] = []
"""Folders that did not exist yet when their kernels were imported."""


@cache
def cache_folder(*folders: Path) -> Path:
    """Where the machine code of these folders' kernels is kept."""
    folder = _cache_root() / fingerprint(Path(__file__).parent, *folders)
    if not folder.exists():
        _missing.append(folder)
    return folder


def fingerprint(*folders: Path) -> str:
    """A hash of the text of every Python file in the folders, and of numba and its options."""
    text = hashlib.sha256(f"{numba.__version__} {config.BOUNDSCHECK}".encode())
    for folder in sorted(set(folders)):
        for file in sorted(folder.glob("*.py")):
            text.update(file.read_bytes())
    return text.hexdigest()[:16]


def _cache_root() -> Path:
    home = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(home) / "swarm-forage"


@cache
def announce() -> None:
    """Tell the user, once, that kernels are about to be compiled, if they are."""
    if _missing:
        sys.stderr.write("swarm-forage: compiling, once for this version: about a minute\n")
