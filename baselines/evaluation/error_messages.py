"""Error messages of commands: one line, and the exit status."""

from collections.abc import Iterator
from concurrent.futures import BrokenExecutor
from contextlib import contextmanager

from swarm_forage_env.errors import ConfigError, UnknownNameError, file_reason

WRONG_INPUT, FAILED = 2, 1
"""Exit statuses: of what was asked, and of what happened on the way."""


def error_message(error: Exception, program: str | None) -> tuple[str, int] | None:
    """The line about an error and the exit status; None for one that only a traceback explains."""
    if isinstance(error, ConfigError | UnknownNameError):
        return str(error), WRONG_INPUT
    if isinstance(error, BrokenExecutor):
        return "a worker was ended from outside; the same command goes on from here", FAILED
    if isinstance(error, OSError):
        return file_reason(error), FAILED
    if not hasattr(error, "format_message"):  # the parser's errors have one
        return None
    message = error.format_message().replace("Value error, ", "")  # a word of pydantic's
    context = getattr(error, "ctx", None)
    command = context.command_path if context else program
    end = "" if message.endswith("?") else "."
    return f"{message.rstrip('.')}{end} See: {command} --help", WRONG_INPUT


@contextmanager
def of_option(prefix: str) -> Iterator[None]:
    """Begin an error message about a value with the option that it was given by.

    >>> with of_option("--"):
    ...     raise ConfigError("seed=-1: must be at least 0")
    Traceback (most recent call last):
        ...
    swarm_forage_env.errors.ConfigError: --seed=-1: must be at least 0
    """
    try:
        yield
    except (ConfigError, UnknownNameError) as error:
        raise ConfigError(f"{prefix}{error}") from None
