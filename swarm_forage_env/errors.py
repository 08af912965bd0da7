"""Exceptions and a warning, whose messages name the cause, the reason and a remedy."""

import re
from collections.abc import Iterable
from difflib import SequenceMatcher, get_close_matches
from numbers import Integral

MAX_SHOWN = 80
"""Length up to which a message shows a value in full [characters]."""


class ConfigError(ValueError):
    """A value that cannot be used: the message names the field, the value and what is allowed."""


class RenamedWarning(FutureWarning):
    """An old name, which still works for one release; the message gives the new name."""


class UnknownNameError(KeyError):
    """An unknown name: the message gives the nearest known one."""

    def __init__(self, kind: str, name: str, known: Iterable[str], note: str = "") -> None:
        """Compose the message: the unknown name, known names, and a note on names left out."""
        names = sorted(set(known))
        near = (
            nearest(name, names)
            or [path for path in names if get_close_matches(name, [path.rpartition(".")[2]])][:1]
        )
        none = "none, as no installed package registers one"
        advice = f"known: {', '.join(names) or none}"
        if near:
            *others, last = (f"'{each}'" for each in near)
            advice = f"did you mean {', '.join(others)}{' or ' if others else ''}{last}?"
        self.message = f"no {kind} named {name!r}, {advice}" + (f"; {note}" if note else "")
        super().__init__(self.message)

    def __str__(self) -> str:
        return self.message


def nearest(name: str, names: Iterable[str]) -> list[str]:
    """Return the names most similar to a name: one, or several that are equally similar.

    Case is ignored, and so are the namespace and the version of a Gymnasium id.

    >>> nearest("ssgif", ["nc", "ssgiff", "ssgikf"])
    ['ssgiff', 'ssgikf']
    >>> nearest("SwarmForage/ES1-v2", ["es1", "es2"])
    ['es1']
    """
    name = re.sub(r"^.*/|-v\d+$", "", name.lower())
    near = get_close_matches(name, names, n=3, cutoff=0.5)
    likeness = {each: SequenceMatcher(None, each, name).ratio() for each in near}
    return sorted(each for each in near if likeness[each] == likeness[near[0]])


def shown(value: object) -> str:
    """Return a value as a message shows it: on one line, of bounded length.

    >>> shown([3, "m"])
    "[3, 'm']"
    >>> shown(10**400)
    '1000000000000000000000000000000000000000...'
    """
    try:
        text = " ".join(repr(value).split())
    except ValueError:  # a whole number of thousands of digits
        text = f"<{type(value).__name__} of thousands of digits>"
    return text if len(text) <= MAX_SHOWN else f"{text[: MAX_SHOWN // 2]}..."


def checked_count(name: str, value: object) -> int:
    """Return a whole number of at least 1; ConfigError, with this name, for anything else."""
    if type(value) is not bool and isinstance(value, Integral) and int(value) >= 1:
        return int(value)
    raise ConfigError(f"{name}={value!r}: must be a whole number, at least 1")


def file_reason(error: OSError) -> str:
    """Return the message of an error and its file, without the system's error number.

    >>> print(file_reason(OSError(28, "No space left on device", "x.png")))
    No space left on device: 'x.png'
    """
    return str(error).removeprefix(f"[Errno {error.errno}] ")
