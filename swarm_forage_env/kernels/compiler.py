"""One compiler for all kernels: options, cache and its key stand here and nowhere else."""

import hashlib
import os
import sys
from functools import cache
from inspect import getfile
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
from numba.core import config

FunctionT = TypeVar("FunctionT")


def kernel(function: FunctionT) -> FunctionT:
    """Compile a function, and keep the machine code until any kernel file changes.

    Numba keys its cache on one file, so that a caller keeps the old body of a callee
    edited in another. Here the key is the text of all files in the folder of the kernels
    and in the folder of the function.
    """
    file = Path(getfile(cast(Any, function)))
    before = config.CACHE_DIR
    config.CACHE_DIR = str(cache_folder(file.parent))
    try:
        compiled: Any = numba.njit(cache=True, error_model="numpy")(cast(Any, function))
        return cast(FunctionT, compiled)
    finally:
        config.CACHE_DIR = before


@cache
def cache_folder(*folders: Path) -> Path:
    """Where the machine code of these folders' kernels is kept; says so when it must be made."""
    folder = _cache_root() / fingerprint(Path(__file__).parent, *folders)
    if not folder.exists():
        _announce()
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
def _announce() -> None:
    if not config.DISABLE_JIT:
        sys.stderr.write("swarm-forage: compiling, once, for this version: under a minute\n")
