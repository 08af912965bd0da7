"""Console of every command: messages on stderr, progress bars, errors and signals."""

import _thread
import signal
import sys
import threading
import time
import warnings
from collections.abc import Collection, Iterator
from concurrent.futures import BrokenExecutor
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, TextIO, cast

from swarm_forage_env.errors import ConfigError, RenamedWarning, UnknownNameError, file_reason

if TYPE_CHECKING:
    from rich.progress import Progress


def say(line: str) -> None:
    """Write one line to stderr, after the program's name."""
    sys.stderr.write(f"swarm-forage: {line}\n")


def count_noun(n: int, noun: str) -> str:
    """Return a number with its noun, in the plural if needed.

    >>> count_noun(1, "robot"), count_noun(20, "episode")
    ('1 robot', '20 episodes')
    """
    return f"{n} {noun}" if n == 1 else f"{n} {noun}s"


def check_file(option: str, file: Path, endings: Collection[str]) -> None:
    """Create the folder of an option's file; ConfigError unless the file can be written."""
    if file.suffix.lower() not in endings:
        raise ConfigError(f"{option} {file}: the name must end in {', '.join(endings)}")
    existed = file.exists()
    try:
        if not file.parent.exists():
            file.parent.mkdir(parents=True)
            say(f"{option} {file}: created the folder {file.parent}")
        file.open("ab").close()
        if not existed:
            file.unlink()
    except OSError as error:
        raise ConfigError(
            f"{option} {file}: cannot be written ({error.strerror}); name another file"
        ) from None


def progress_bar(unit: str) -> "Progress":
    """Return a progress bar on stderr that counts units; it is hidden if stderr is no terminal."""
    from rich import progress
    from rich.console import Console

    console = Console(stderr=True)
    columns = (
        unit, progress.BarColumn(), progress.MofNCompleteColumn(),
        "elapsed", progress.TimeElapsedColumn(), "left", progress.TimeRemainingColumn(),
        "{task.description}",
    )  # fmt: skip
    return progress.Progress(*columns, console=console, disable=not console.is_terminal)


@contextmanager
def report_old_names() -> Iterator[None]:
    """Report each use of an old name in one line on stderr."""
    with warnings.catch_warnings():
        warnings.simplefilter("default", RenamedWarning)
        show = warnings.showwarning

        def report(
            message: Warning | str, category: type[Warning], filename: str, lineno: int,
            file: TextIO | None = None, line: str | None = None,
        ) -> None:  # fmt: skip
            if issubclass(category, RenamedWarning):
                say(str(message))
            else:
                show(message, category, filename, lineno, file, line)

        warnings.showwarning = report
        yield


WRONG_INPUT, FAILED = 2, 1  # exit statuses: the command was wrong, or failed while it ran


def error_message(error: Exception, program: str | None) -> tuple[str, int] | None:
    """Return the message of an error and the exit status; None if only a traceback explains it."""
    if isinstance(error, ConfigError | UnknownNameError):
        return str(error), WRONG_INPUT
    if isinstance(error, BrokenExecutor):
        return "a worker process was killed; the same command resumes from here", FAILED
    if isinstance(error, OSError):
        return file_reason(error), FAILED
    if not hasattr(error, "format_message"):  # the parser's errors have one
        return None
    message = error.format_message().replace("Value error, ", "")  # added by pydantic
    context = getattr(error, "ctx", None)
    command = context.command_path if context else program
    end = "" if message.endswith("?") else "."
    return f"{message.rstrip('.')}{end} See: {command} --help", WRONG_INPUT


@contextmanager
def of_option(prefix: str) -> Iterator[None]:
    """Prefix an error message about a value with the name of its option: `--seed=-1: must be`."""
    try:
        yield
    except (ConfigError, UnknownNameError) as error:
        raise ConfigError(f"{prefix}{error}") from None


PAUSE = 0.01  # time after which a signal that could not be handled is sent again [s]


@contextmanager
def interrupts_raised() -> Iterator[None]:
    """Raise KeyboardInterrupt on SIGTERM; on SIGINT and SIGHUP unless this process ignores them.

    If Python drops the exception, as in a finaliser, it is raised again soon after.
    """
    numbers = [signal.SIGTERM]
    if sys.platform != "win32" and signal.getsignal(signal.SIGHUP) is signal.SIG_DFL:
        numbers.append(signal.SIGHUP)
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        numbers.append(signal.SIGINT)
    handlers = {number: signal.signal(number, _interrupt) for number in numbers}
    hook = sys.unraisablehook

    def send_again_if_dropped(dropped: "sys.UnraisableHookArgs") -> None:
        if issubclass(dropped.exc_type, KeyboardInterrupt):
            _send_again(signal.SIGINT)
        else:
            hook(dropped)

    sys.unraisablehook = send_again_if_dropped
    try:
        yield
    finally:
        sys.unraisablehook = hook
        for number, handler in handlers.items():
            signal.signal(number, handler)


def _interrupt(number: int, frame: FrameType | None) -> None:
    """Raise KeyboardInterrupt; later if pymunk frees memory now, as it would crash."""
    if _is_freeing(frame):
        _send_again(number)
    else:
        raise KeyboardInterrupt


def _is_freeing(frame: FrameType | None) -> bool:
    while frame is not None:
        module = frame.f_globals.get("__name__", "")
        if module.startswith("pymunk") and "free" in frame.f_code.co_name:
            return True
        frame = frame.f_back
    return False


def _send_again(number: int) -> None:
    """Send the main thread a signal after a pause, from a thread that starts without a lock."""

    def send() -> None:
        time.sleep(PAUSE)
        if sys.platform == "win32":  # the main thread handles every signal
            signal.raise_signal(number)
        else:
            signal.pthread_kill(cast(int, threading.main_thread().ident), number)

    _thread.start_new_thread(send, ())
