"""Atomic writing: a file appears whole or not at all, under a temporary name until it is whole."""

import contextlib
import os
import re
import socket
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import quote

TEMPORARY = ".tmp"
"""Ending of temporary files; their names start with `_`, which readers of datasets skip."""

WRITE_RETRIES = 5
"""Attempts to write a file whose temporary file another run removes."""


def write_atomically(file: Path, content: bytes) -> None:
    """Write a file that appears whole or not at all, replacing an older one; create its folder."""
    for attempt in range(WRITE_RETRIES):
        try:
            with replacing(file) as temporary:
                temporary.write_bytes(content)
            return
        except FileNotFoundError:  # removed by a run that has just started on the same folder
            if attempt == WRITE_RETRIES - 1:
                raise


@contextlib.contextmanager
def replacing(file: Path) -> Iterator[Path]:
    """Yield a temporary path, which replaces the file if no error occurs.

    The folder of the file is created, and the content flushed to the disk. After an error the older
    file is unchanged, and no temporary file is left; an OSError names the file.
    """
    temporary = temporary_of(file)
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        yield temporary
        _fsync(temporary, os.O_RDWR)
        temporary.replace(file)
    except BaseException as error:
        with contextlib.suppress(OSError):
            temporary.unlink(missing_ok=True)
        if isinstance(error, OSError) and error.errno is not None:
            raise OSError(error.errno, error.strerror, str(file)) from error
        raise
    with contextlib.suppress(OSError):  # if the system can
        _fsync(file.parent, os.O_RDONLY)


def temporary_of(file: Path) -> Path:
    """Return the path of this process's temporary file for a file."""
    host = quote(socket.gethostname(), safe="")
    return file.with_name(f"_{file.name}.{host}-{os.getpid()}{TEMPORARY}")


def sweep(folder: Path, names: str) -> None:
    """Remove the temporary files that killed runs left for files with matching names."""
    ours = re.compile(rf"_(?:{names})\.[^/]+-[0-9]+{re.escape(TEMPORARY)}")
    for leftover in folder.glob(f"_*{TEMPORARY}"):
        if ours.fullmatch(leftover.name) and leftover.is_file():
            leftover.unlink(missing_ok=True)


def _fsync(path: Path, flags: int) -> None:
    descriptor = os.open(path, flags)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
