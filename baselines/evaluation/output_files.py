"""Output files: checked before anything runs, and written atomically."""

import contextlib
import os
import socket
from collections.abc import Collection
from pathlib import Path
from urllib.parse import quote

from swarm_forage_env.errors import ConfigError

TEMPORARY = ".tmp"
"""Ending of temporary files; their names start with `_`, which readers of datasets skip."""

WRITE_RETRIES = 5
"""How often a file is written whose temporary file another run removes."""


def write_atomically(file: Path, content: bytes) -> None:
    """Write a file that appears whole or not at all, over an older one; its folder is made."""
    file.parent.mkdir(parents=True, exist_ok=True)
    temporary = temporary_of(file)
    for attempt in range(WRITE_RETRIES):
        with temporary.open("wb") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        try:
            temporary.replace(file)
            break
        except FileNotFoundError:  # removed by a run that has just started on the same folder
            if attempt == WRITE_RETRIES - 1:
                raise
    fsync_folder(file.parent)


def temporary_of(file: Path) -> Path:
    """The temporary file of this process that stands for a file until it is whole."""
    host = quote(socket.gethostname(), safe="")
    return file.with_name(f"_{file.name}.{host}-{os.getpid()}{TEMPORARY}")


def fsync_folder(folder: Path) -> None:
    """Flush a folder's list of names to the disk, where the system can."""
    with contextlib.suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


def check_file(option: str, file: Path, endings: Collection[str]) -> None:
    """Raise ConfigError unless an option's file can be written; its folder is made."""
    if file.suffix.lower() not in endings:
        raise ConfigError(f"{option} {file}: the name must end in {', '.join(endings)}")
    existed = file.exists()
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        with file.open("ab"):
            pass
        if not existed:
            file.unlink()
    except OSError as error:
        raise ConfigError(
            f"{option} {file}: cannot be written ({error.strerror}); name another file"
        ) from None
