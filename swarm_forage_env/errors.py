"""What goes wrong on purpose: exceptions and a warning, each naming what, why and what would do."""

import re
from collections.abc import Iterable
from difflib import SequenceMatcher, get_close_matches
from numbers import Integral

MAX_SHOWN = 80
"""Characters of a value that a message shows whole."""


class ConfigError(ValueError):
    """A value that cannot be used: the message names the field, the value and what is allowed."""


class RenamedWarning(FutureWarning):
    """An old name, which goes on working for one release: the message tells the new one."""


class UnknownNameError(KeyError):
    """An unknown name: the message gives the nearest known one."""

    def __init__(self, kind: str, name: str, known: Iterable[str], note: str = "") -> None:
        """Say what is unknown, which names are known, and in a note why others are not."""
        names = sorted(known)
        near = (
            nearest(name, names)
            or [path for path in names if get_close_matches(name, [path.rpartition(".")[2]])][:1]
        )
        advice = f"known: {', '.join(names) or 'none'}"
        if near:
            *others, last = (f"'{each}'" for each in near)
            advice = f"did you mean {', '.join(others)}{' or ' if others else ''}{last}?"
        self.message = f"no {kind} named {name!r}, {advice}" + (f"; {note}" if note else "")
        super().__init__(self.message)

    def __str__(self) -> str:
        return self.message


def nearest(name: str, names: Iterable[str]) -> list[str]:
    """The names that are most like a name: one, or several that are equally like it.

    Capitals do not count, nor what an id of Gymnasium has around a name.

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
    """A value as a message shows it: on one line, of a bounded length.

    >>> shown([3, "m"])
    "[3, 'm']"
    >>> shown(10**400)
    '1000000000000000000000000000000000000000...'
    """
    try:
        text = " ".join(repr(value).split())
    except ValueError:  # of a whole number of thousands of digits
        text = f"<{type(value).__name__} of thousands of digits>"
    return text if len(text) <= MAX_SHOWN else f"{text[: MAX_SHOWN // 2]}..."


def checked_count(name: str, value: object) -> int:
    """A whole number of at least 1; ConfigError for anything else, under this name."""
    if type(value) is not bool and isinstance(value, Integral) and int(value) >= 1:
        return int(value)
    raise ConfigError(f"{name}={value!r}: must be a whole number, at least 1")


def file_reason(error: OSError) -> str:
    """What is wrong and with which file, without the system's number.

    >>> print(file_reason(OSError(28, "No space left on device", "x.png")))
    No space left on device: 'x.png'
    """
    return str(error).removeprefix(f"[Errno {error.errno}] ")
