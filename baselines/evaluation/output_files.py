"""Output files that a command is asked to write, checked before anything runs."""

from collections.abc import Collection
from pathlib import Path

from swarm_forage_env.errors import ConfigError


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
