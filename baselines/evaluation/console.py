"""Messages and progress bars of every command, on stderr."""

import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, cast

from swarm_forage_env.errors import RenamedWarning

if TYPE_CHECKING:
    from rich.progress import Progress


def say(line: str) -> None:
    """Write one line to stderr, under the program's name."""
    sys.stderr.write(f"swarm-forage: {line}\n")


def progress_bar(unit: str) -> "Progress":
    """A progress bar on stderr that counts these units; invisible if stderr is no terminal."""
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    console = Console(stderr=True)
    columns = (
        unit, BarColumn(), MofNCompleteColumn(), "elapsed", TimeElapsedColumn(),
        "left", TimeRemainingColumn(), "{task.description}",
    )  # fmt: skip
    return Progress(*columns, console=console, disable=not console.is_terminal)


@contextmanager
def old_names_told() -> Iterator[None]:
    """Tell of each old name that a command is given in one line on stderr."""
    with warnings.catch_warnings():
        warnings.simplefilter("default", RenamedWarning)
        show = warnings.showwarning

        def tell(message: Warning | str, category: type[Warning], *where: Any) -> None:  # noqa: ANN401 as Python's
            if issubclass(category, RenamedWarning):
                say(str(message))
            else:
                show(message, category, *where)

        warnings.showwarning = cast(Any, tell)
        yield
