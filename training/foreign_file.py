"""Reading of untrusted files, with limits on their sizes and one-line error messages."""

import io
import stat
import struct
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path

from pydantic import ValidationError

from swarm_forage_env.errors import ConfigError

# Largest number of bytes that are read:
LARGEST = 256 * 2**20  # weights; networks of three layers of 1,024 units have a fifth of that
LARGEST_ZIP = 4 * LARGEST  # zip of a model, whose optimiser's state is twice its weights
MAX_JSON = 16 * 2**20  # JSON of a model: one megabyte for a few thousand robots
LARGEST_CARD = 2 * 2**20  # card: one megabyte with a learning curve of a few thousand points

PACKED = zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED
"""Accepted compression methods: others can expand without limit while a single byte is read."""

DAMAGE = (zipfile.BadZipFile, zlib.error, struct.error, KeyError, ValueError, RuntimeError,
          OverflowError, EOFError, OSError)  # fmt: skip
"""Errors raised for a zip that is damaged, encrypted or compressed by an unknown method."""


def reason(error: Exception) -> str:
    """Return the printable characters of the first line of an error, at most 200."""
    text = str(error).strip().partition("\n")[0]
    if isinstance(error, ValidationError):
        first = error.errors(include_url=False, include_context=False, include_input=False)[0]
        text = ": ".join((".".join(map(str, first["loc"])), first["msg"])).removeprefix(": ")
    text = "".join(letter for letter in text if letter.isprintable())
    return (text if len(text) <= 200 else f"{text[:200]}...") or type(error).__name__


def check_file(file: Path, kind: str, largest: int = LARGEST) -> None:
    """Raise ConfigError unless the path is a regular file of at most `largest` bytes."""
    try:
        state = file.stat()
    except (OSError, ValueError) as error:
        raise _unreadable(file, kind, error) from None
    if not stat.S_ISREG(state.st_mode):  # a pipe would block
        raise ConfigError(f"{kind} {file}: cannot be read (it is no regular file)")
    if state.st_size > largest:
        raise ConfigError(f"{kind} {file}: {_too_large(state.st_size, largest)}")


def read_file(file: Path, kind: str, largest: int = LARGEST) -> bytes:
    """Return the content of a file. ConfigError if it cannot be read or has more bytes."""
    check_file(file, kind, largest)
    try:
        with file.open("rb") as stream:
            content = stream.read(largest + 1)
    except OSError as error:
        raise _unreadable(file, kind, error) from None
    if len(content) > largest:  # the file grows, or reports no size
        raise ConfigError(f"{kind} {file}: {_too_large(len(content), largest)}")
    return content


def read_members(file: Path, largest: Mapping[str, int]) -> list[bytes]:
    """Read members of a zip up to these sizes; ValueError if one is missing, larger or damaged."""
    try:
        with zipfile.ZipFile(file) as archive:
            return [_member(archive, name, bound) for name, bound in largest.items()]
    except DAMAGE as error:
        raise ValueError(reason(error)) from None


def check_zip(content: bytes | Path) -> None:
    """Raise ValueError unless it is a zip whose members have at most `LARGEST` bytes in total."""
    source = content if isinstance(content, Path) else io.BytesIO(content)
    try:
        with zipfile.ZipFile(source) as archive:
            size = sum(each.file_size for each in archive.infolist())
    except DAMAGE as error:
        raise ValueError(reason(error)) from None
    if size > LARGEST:
        raise ValueError(_too_large(size, LARGEST))


def _member(archive: zipfile.ZipFile, name: str, largest: int) -> bytes:
    """Return the content of a member, up to the size in the zip's directory."""
    member = archive.getinfo(name)
    if member.file_size > largest:
        raise ValueError(f"'{name}' {_too_large(member.file_size, largest)}")
    if member.compress_type not in PACKED:
        raise ValueError(f"'{name}' is neither stored nor deflated")
    with archive.open(member) as stream:
        return stream.read(member.file_size + 1)


def _too_large(size: int, largest: int) -> str:
    return f"has {size / 2**20:,.1f} MiB; at most {largest / 2**20:g} MiB are read"


def _unreadable(file: Path, kind: str, error: Exception) -> ConfigError:
    why = error.strerror if isinstance(error, OSError) else str(error)
    name = str(file)
    short_name = name if len(name) <= 200 else f"{name[:200]}..."
    return ConfigError(f"{kind} {short_name}: cannot be read ({why})")
