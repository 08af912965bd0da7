"""What goes wrong on purpose: exceptions and a warning, each naming what, why and what would do."""

from collections.abc import Iterable
from difflib import get_close_matches


class ConfigError(ValueError):
    """A value that cannot be used: the message names the field, the value and what is allowed."""


class RenamedWarning(FutureWarning):
    """An old name, which goes on working for one release: the message tells the new one."""


class UnknownNameError(KeyError):
    """A name that stands for nothing: the message names the nearest one that does."""

    def __init__(self, kind: str, name: str, known: Iterable[str], note: str = "") -> None:
        """Say which kind of thing is unknown, under which name, and which names are known.

        A note tells why others are not.
        """
        names = sorted(known)
        near = get_close_matches(name, names, n=1, cutoff=0.5) or [
            path for path in names if get_close_matches(name, [path.rpartition(".")[2]])
        ]
        advice = f"did you mean '{near[0]}'?" if near else f"known: {', '.join(names) or 'none'}"
        self.message = f"no {kind} named '{name}', {advice}" + (f"; {note}" if note else "")
        super().__init__(self.message)

    def __str__(self) -> str:
        """The message itself, without the quotes that KeyError puts around it."""
        return self.message
