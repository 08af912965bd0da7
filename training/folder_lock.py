"""Lock of a training's folder: one run at a time writes there, and another is told whose it is."""

import os
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from swarm_forage_env.atomic_write import sweep
from swarm_forage_env.errors import ConfigError
from training.checkpoint import not_writable

LOCK = "lock"
"""File of the lock in the folder; it holds the process and the machine that have it."""

FILES = r"(best|checkpoint|latest)\.(json|safetensors)"
"""Regular expression of the files of a training that are written atomically."""


@contextmanager
def lock_folder(folder: Path) -> Iterator[None]:
    """Hold a folder, which is made, and sweep what killed runs left there.

    The system takes the lock back when the process ends, however it ends. ConfigError if another
    run holds the folder, or if it cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        stream = (folder / LOCK).open("ab+", buffering=0)
    except OSError as error:
        raise not_writable(folder, error) from None
    with stream:
        _take(stream, folder)
        try:
            stream.truncate(0)
            stream.write(f"{os.getpid()} on {socket.gethostname()}".encode())
        except OSError as error:
            raise not_writable(folder, error) from None
        sweep(folder, FILES)
        yield


def _take(stream: IO[bytes], folder: Path) -> None:
    """Take the lock, where the system and the file system have such locks."""
    try:
        import fcntl
    except ModuleNotFoundError:  # Windows
        return
    try:
        fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        stream.seek(0)
        who = stream.read().decode(errors="replace")
        raise ConfigError(
            f"--out {folder}: process {who} is training there; wait for it, or name another folder"
        ) from None
    except OSError:  # a file system without locks
        return
