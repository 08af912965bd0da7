"""Cache files of machine code, checked for damage and for access by other users.

A file begins with the hash of its content. A file that is damaged, or that refers to a module which
was renamed, counts as missing. A folder to which other users may write is not used.
"""

import os
import pickle
import stat
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from hashlib import sha256
from io import BytesIO
from pathlib import Path

from numba.core.caching import IndexDataCacheFile

HASH = sha256().digest_size
"""Length of the hash at the beginning of a file [byte]."""

MOVED = ImportError, AttributeError
"""Errors for machine code that refers to a renamed module or class."""


def cache_folder() -> Path:
    """Return the folder of the machine code of all kernels."""
    home = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(home) / "swarm-forage" / "machine-code"


def is_trusted(folder: Path) -> bool:
    """Return whether only the user and root may write to a folder, or it is missing; else warn."""
    with suppress(OSError):
        status = folder.stat()
        if hasattr(os, "geteuid") and (
            status.st_uid not in {os.geteuid(), 0} or status.st_mode & (stat.S_IWGRP | stat.S_IWOTH)
        ):
            warn_once(f"{folder}: others may write there (chmod 700 would do)")
            return False
    return True


@cache
def warn_once(reason: str) -> None:
    """Print, once, that no machine code is cached, and why."""
    sys.stderr.write(
        "swarm-forage: compiled kernels are not kept, and every process compiles them again:"
        f" {reason}; set the environment variable XDG_CACHE_HOME to another folder\n"
    )


class CheckedFiles(IndexDataCacheFile):  # type: ignore[misc]
    """Numba's cache files of one kernel, each beginning with the hash of its content."""

    def _load_index(self) -> dict[object, str]:
        content = _sound_content(Path(self._index_path))
        if content is None:
            return {}
        stream = BytesIO(content)
        try:
            version, (stamp, overloads) = pickle.load(stream), pickle.load(stream)
        except MOVED:
            return {}
        is_fresh = (version, stamp) == (self._version, self._source_stamp)
        return dict(overloads) if is_fresh else {}

    def _load_data(self, name: str) -> object:
        content = _sound_content(Path(self._data_path(name)))
        try:
            return None if content is None else pickle.loads(content)
        except MOVED:
            return None

    @contextmanager
    def _open_for_write(self, filepath: str) -> Iterator[BytesIO]:
        content = BytesIO()
        yield content
        with super()._open_for_write(filepath) as stream:
            stream.write(sha256(content.getvalue()).digest() + content.getvalue())


def _sound_content(file: Path) -> bytes | None:
    try:
        whole = file.read_bytes()
    except FileNotFoundError:
        return None
    content = whole[HASH:]
    return content if sha256(content).digest() == whole[:HASH] else None
