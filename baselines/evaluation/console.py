"""Messages and progress bars of every command, on stderr."""

import sys
from typing import TYPE_CHECKING

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
