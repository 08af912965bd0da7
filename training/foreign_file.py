"""Files that strangers may have made: read with a limit on their size, refused in one line."""

import io
import stat
import struct
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path

from pydantic import ValidationError

from swarm_forage_env.errors import ConfigError

# The most bytes that are read:
LARGEST = 256 * 2**20  # of weights: a network of three layers of 1,024 has a fifth of that
LARGEST_ZIP = 4 * LARGEST  # of a model: its optimiser's state is twice its weights
LARGEST_TELLING = 16 * 2**20  # of a model's JSON: it has a megabyte for some thousand robots
LARGEST_CARD = 2 * 2**20  # with a learning curve of some thousand points it has one megabyte

PACKED = zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED
"""How a member may be packed: others swell to any size while a single byte of them is read."""

DAMAGE = (zipfile.BadZipFile, zlib.error, struct.error, KeyError, ValueError, RuntimeError,
          OverflowError, EOFError, OSError)  # fmt: skip
"""Raised by a zip that is damaged, encrypted or packed in an unknown way."""


def reason(error: Exception) -> str:
    """The first line of an error, its printable characters, 200 at most."""
    text = str(error).strip().partition("\n")[0]
    if isinstance(error, ValidationError):
        first = error.errors(include_url=False, include_context=False, include_input=False)[0]
        text = ": ".join((".".join(map(str, first["loc"])), first["msg"])).removeprefix(": ")
    text = "".join(letter for letter in text if letter.isprintable())
    return (text if len(text) <= 200 else f"{text[:200]}...") or type(error).__name__


def check_file(file: Path, what: str, largest: int = LARGEST) -> None:
    """ConfigError unless it is a regular file of at most `largest` bytes."""
    try:
        state = file.stat()
    except (OSError, ValueError) as error:
        raise _unreadable(file, what, error) from None
    if not stat.S_ISREG(state.st_mode):  # a pipe would block
        raise ConfigError(f"{what} {file}: cannot be read (it is no regular file)")
    if state.st_size > largest:
        raise ConfigError(f"{what} {file}: {_too_large(state.st_size, largest)}")


def read_file(file: Path, what: str, largest: int = LARGEST) -> bytes:
    """The content of a file; ConfigError for one that cannot be read or has more bytes."""
    check_file(file, what, largest)
    try:
        with file.open("rb") as stream:
            content = stream.read(largest + 1)
    except OSError as error:
        raise _unreadable(file, what, error) from None
    if len(content) > largest:  # of a file that grows, or that has no size
        raise ConfigError(f"{what} {file}: {_too_large(len(content), largest)}")
    return content


def read_members(file: Path, largest: Mapping[str, int]) -> list[bytes]:
    """Members of a zip, of at most these bytes; ValueError if one is missing, larger or damaged."""
    try:
        with zipfile.ZipFile(file) as archive:
            return [_member(archive, name, bound) for name, bound in largest.items()]
    except DAMAGE as error:
        raise ValueError(reason(error)) from None


def check_zip(content: bytes | Path) -> None:
    """ValueError unless it is a zip whose members have at most `LARGEST` bytes."""
    source = content if isinstance(content, Path) else io.BytesIO(content)
    try:
        with zipfile.ZipFile(source) as archive:
            size = sum(each.file_size for each in archive.infolist())
    except DAMAGE as error:
        raise ValueError(reason(error)) from None
    if size > LARGEST:
        raise ValueError(_too_large(size, LARGEST))


def _member(archive: zipfile.ZipFile, name: str, largest: int) -> bytes:
    """The content of a member, up to the size in the zip's directory."""
    member = archive.getinfo(name)
    if member.file_size > largest:
        raise ValueError(f"'{name}' {_too_large(member.file_size, largest)}")
    if member.compress_type not in PACKED:
        raise ValueError(f"'{name}' is neither stored nor deflated")
    with archive.open(member) as stream:
        return stream.read(member.file_size + 1)


def _too_large(size: int, largest: int) -> str:
    return f"has {size / 2**20:,.1f} MiB; at most {largest / 2**20:g} MiB are read"


def _unreadable(file: Path, what: str, error: Exception) -> ConfigError:
    why = error.strerror if isinstance(error, OSError) else str(error)
    name = str(file)
    short_name = name if len(name) <= 200 else f"{name[:200]}..."
    return ConfigError(f"{what} {short_name}: cannot be read ({why})")
