"""Ctrl-C, SIGTERM and SIGHUP: a KeyboardInterrupt of the command, which no moment loses."""

import _thread
import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from types import FrameType
from typing import Any, cast

PAUSE = 0.01
"""After which a signal that came at a bad moment is sent again [s]."""


@contextmanager
def interrupts_raised() -> Iterator[None]:
    """Raise KeyboardInterrupt on SIGTERM, on SIGINT and SIGHUP unless this process ignores them.

    Where Python would drop the exception, as in a finaliser, it is raised soon after.
    """
    numbers = [signal.SIGTERM]
    if signal.getsignal(signal.SIGHUP) is signal.SIG_DFL:
        numbers.append(signal.SIGHUP)
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        numbers.append(signal.SIGINT)
    handlers = {number: signal.signal(number, _interrupt) for number in numbers}
    hook = sys.unraisablehook
    sys.unraisablehook = partial(_send_again_if_dropped, hook)
    try:
        yield
    finally:
        sys.unraisablehook = hook
        for number, handler in handlers.items():
            signal.signal(number, handler)


def _interrupt(number: int, frame: FrameType | None) -> None:
    """Raise KeyboardInterrupt, but not while pymunk frees memory, which ends in a crash."""
    if _is_freeing(frame):
        _send_again(number)
    else:
        raise KeyboardInterrupt


def _is_freeing(frame: FrameType | None) -> bool:
    """Whether pymunk is freeing a space, a body or a shape."""
    while frame is not None:
        module = frame.f_globals.get("__name__", "")
        if module.startswith("pymunk") and "free" in frame.f_code.co_name:
            return True
        frame = frame.f_back
    return False


def _send_again_if_dropped(hook: Any, dropped: Any) -> None:  # noqa: ANN401 typeshed's own
    if issubclass(dropped.exc_type, KeyboardInterrupt):
        _send_again(signal.SIGINT)
    else:
        hook(dropped)


def _send_again(number: int) -> None:
    """Send the main thread a signal after a pause, by a thread that takes no lock to start."""

    def send() -> None:
        time.sleep(PAUSE)
        signal.pthread_kill(cast(int, threading.main_thread().ident), number)

    _thread.start_new_thread(send, ())
