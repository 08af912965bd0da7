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
"""How often a file is written whose temporary file another run removes."""


def write_atomically(file: Path, content: bytes) -> None:
    """Write a file that appears whole or not at all, over an older one; its folder is made."""
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
    """A temporary path for the content of a file, which takes its name if no error occurs.

    The folder of the file is made, and the content flushed to the disk. After an error the older
    file stands as it was, and no temporary is left; an OSError names the file.
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
    with contextlib.suppress(OSError):  # where the system can
        _fsync(file.parent, os.O_RDONLY)


def temporary_of(file: Path) -> Path:
    """The temporary file of this process for a file until it is whole."""
    host = quote(socket.gethostname(), safe="")
    return file.with_name(f"_{file.name}.{host}-{os.getpid()}{TEMPORARY}")


def sweep(folder: Path, names: str) -> None:
    """Remove the temporaries that killed runs left for files whose names match an expression."""
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
