"""Output folder of a training: its checkpoint (arrays and learning curve in one file) and lock."""

import hashlib
import os
import socket
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from baselines.evaluation.statistics import mean_interval
from swarm_forage_env.arrays import Array, Int64
from swarm_forage_env.atomic_write import sweep, write_atomically
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.parameters import Parameters
from training.policy_file import CurvePoint, Interval

CHECKPOINT = "checkpoint.safetensors"

BEST_POLICY = "best.safetensors"
"""File of the policy with the best score on the held-back (validation) seeds so far."""

RECORD = "record"  # key of the header in the metadata of the safetensors file

Identity = dict[str, str]


class Header(Parameters):
    """Header of a checkpoint: the experiment's identity and the learning curve so far."""

    experiment: Identity
    curve: tuple[CurvePoint, ...]
    sha256: str
    """Hash of the rest of the header and of all arrays."""

    def hashed(self, arrays: Mapping[str, Array]) -> str:
        """Return the hash of this header, without its `sha256`, and of the arrays."""
        digest = hashlib.sha256(self.model_copy(update={"sha256": ""}).model_dump_json().encode())
        for name, array in sorted(arrays.items()):
            digest.update(f"{name} {array.dtype} {array.shape}".encode() + array.tobytes())
        return digest.hexdigest()


def write_checkpoint(
    file: Path, identity: Identity, curve: list[CurvePoint], arrays: dict[str, Array]
) -> None:
    """Write the checkpoint of an experiment, replacing the previous one."""
    from safetensors.numpy import save

    header = Header(experiment=identity, curve=tuple(curve), sha256="")
    header = header.model_copy(update={"sha256": header.hashed(arrays)})
    content = save(arrays, {RECORD: header.model_dump_json()})
    try:
        write_atomically(file, content)
    except OSError as error:
        raise not_writable(file.parent, error) from None


def not_writable(folder: Path, error: OSError) -> ConfigError:
    """Return the ConfigError for an output folder that cannot be written."""
    return ConfigError(f"--out {folder}: cannot be written ({error.strerror}); name another folder")


def read_checkpoint(file: Path, identity: Identity) -> tuple[list[CurvePoint], dict[str, Array]]:
    """Read the learning curve and the arrays. ConfigError if damaged or of another experiment."""
    from safetensors import SafetensorError, safe_open

    try:
        with safe_open(file, "np") as stream:
            record = Header.model_validate_json(stream.metadata()[RECORD])
            arrays = {name: stream.get_tensor(name) for name in stream.keys()}  # noqa: SIM118 no mapping
    except (OSError, SafetensorError, KeyError, TypeError, ValueError) as error:
        raise unreadable(file, str(error).splitlines()[0]) from None
    if record.sha256 != record.hashed(arrays):
        raise unreadable(file, "its content is damaged")
    recorded = record.experiment
    for name in (*identity, *sorted(recorded.keys() - identity.keys())):
        there, here = recorded.get(name, "missing"), identity.get(name, "missing")
        if there != here:
            raise ConfigError(
                f"--out {file.parent}: holds an experiment with {name} = {there}, not"
                f" {here}; name another folder"
            )
    return list(record.curve), arrays


def unreadable(file: Path, why: str) -> ConfigError:
    """Return the ConfigError for a checkpoint that cannot be used."""
    return ConfigError(f"checkpoint {file}: cannot be read ({why}); remove it to start again")


def mean_with_interval(trips: Int64[Array, " worlds"]) -> Interval:
    """Return the mean over worlds and its 95 % interval, which for one world is the mean."""
    estimate = mean_interval(trips.tolist())
    assert estimate is not None
    low, high = estimate.ends
    return Interval(low=low, mean=estimate.value, high=high)


FAR = 2**30
"""Offset of the byte of the lock file that is locked on Windows."""

LOCK = "lock"  # name of the lock file, which contains the process and the host of the holder

FILES = r"(best|checkpoint|latest)\.(json|safetensors)"
"""Regular expression for the files of a training that are written atomically."""


@contextmanager
def lock_folder(folder: Path) -> Iterator[None]:
    """Create and lock a folder, and remove the temporary files of killed runs.

    The operating system releases the lock when the process ends for any reason. ConfigError if
    another run holds the lock or the folder cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        stream = (folder / LOCK).open("ab+", buffering=0)
    except OSError as error:
        raise not_writable(folder, error) from None
    with stream:
        _lock(stream, folder)
        try:
            stream.truncate(0)
            stream.write(f"{os.getpid()} on {socket.gethostname()}".encode())
        except OSError as error:
            raise not_writable(folder, error) from None
        sweep(folder, FILES)
        yield


def _lock(stream: IO[bytes], folder: Path) -> None:
    """Lock a file, if the file system supports locks. ConfigError if another process holds it."""
    try:
        if sys.platform == "win32":
            import msvcrt

            stream.seek(FAR)  # a locked byte cannot be read
            msvcrt.locking(stream.fileno(), msvcrt.LK_NBLCK, 1)
        else:
            import fcntl

            fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except (BlockingIOError, PermissionError):
        stream.seek(0)
        pid = stream.read().decode(errors="replace")
        raise ConfigError(
            f"--out {folder}: process {pid} is training there; wait for it, or name another folder"
        ) from None
    except OSError:  # a file system without locks
        return
