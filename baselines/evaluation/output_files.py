"""Output files and folders: their names are checked before anything runs."""

from collections.abc import Collection
from pathlib import Path
from urllib.parse import quote

from baselines.evaluation.console import say
from swarm_forage_env.errors import ConfigError

LONGEST_NAME = 255  # of a file or folder [byte], on the usual file systems


def folder_name(name: str, prefix: str = "") -> str:
    """The name of a folder: a prefix, and any text as readers of hive partitions decode it.

    ConfigError for a text that names no folder of its own.

    >>> folder_name("a/b", "scenario=")
    'scenario=a%2Fb'
    """
    found = prefix + quote(name, safe="")
    if found in {"", ".", ".."} or len(found) > LONGEST_NAME:
        shown = name if len(name) < 40 else f"{name[:40]}..."
        raise ConfigError(f"name='{shown}': cannot name a folder; give it another name")
    return found


def check_file(option: str, file: Path, endings: Collection[str]) -> None:
    """Raise ConfigError unless an option's file can be written.

    A folder that is missing is made, and the user told.
    """
    if file.suffix.lower() not in endings:
        raise ConfigError(f"{option} {file}: the name must end in {', '.join(endings)}")
    existed, had_folder = file.exists(), file.parent.exists()
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        if not had_folder:
            say(f"{option} {file}: made the folder {file.parent}")
        with file.open("ab"):
            pass
        if not existed:
            file.unlink()
    except OSError as error:
        raise ConfigError(
            f"{option} {file}: cannot be written ({error.strerror}); name another file"
        ) from None
