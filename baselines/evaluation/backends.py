"""Backends: what spreads the calls of a command over worker processes.

joblib's workers are on this machine; those of a Ray cluster (`ray_backend`) on any of its nodes.
Neither the backend nor the number of workers ever changes a result.
"""

import os
import signal
import sys
import threading
import time
import warnings
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass, field
from functools import cache, partial
from multiprocessing import resource_tracker as stdlib_tracker
from operator import itemgetter
from typing import TypeVar

from joblib import Parallel, delayed, parallel_config
from joblib.externals.loky.backend import resource_tracker as loky_tracker

from swarm_forage_env.worlds_on_cpu import Device

JobT = TypeVar("JobT")
ResultT = TypeVar("ResultT")

Results = Generator[ResultT, None, None]  # what calls return, as they end

IDLE = 86_400.0
"""A worker without a job ends after this time [s].

After joblib's 300 s it may end just as a job comes. joblib then warns in its own thread, and where
warnings are errors (`python -W error`) that ends the thread, and the call waits for ever.
"""

SETTLE = 0.1
"""Time for joblib's thread to hand over the first calls, before a signal that was held back [s].

If it is stopped before, it ends with a KeyError, whose traceback it prints.
"""


@dataclass(frozen=True)
class Backend:
    """Runs calls in worker processes."""

    workers: int = 1  # number of calls that run at a time
    threads: int = 1  # number of threads of each call
    device: Device = field(default="cpu", kw_only=True)  # where the worlds of a call run

    def run(self, function: Callable[[JobT], ResultT], jobs: Sequence[JobT]) -> Results[ResultT]:
        """Call the function with every job; yield what it returns as the calls end.

        Closing the iterator ends the calls that run. BrokenExecutor if workers keep dying.
        """
        raise NotImplementedError


class JoblibBackend(Backend):
    """Worker processes of this machine; a single worker is this process itself."""

    def run(self, function: Callable[[JobT], ResultT], jobs: Sequence[JobT]) -> Results[ResultT]:
        """Call the function with every job; workers end with this process, even if killed."""
        if not jobs:
            return
        workers = min(self.workers, len(jobs))
        with parallel_config(backend="loky", idle_worker_timeout=IDLE):
            parallel = Parallel(n_jobs=workers, return_as="generator_unordered", batch_size=1)
        finished: Results[ResultT] | None = None
        try:
            with defer_interrupts():
                calls = (delayed(_call)(function, job, os.getpid()) for job in jobs)
                finished = parallel(calls)
            for each in finished:  # noqa: UP028 `yield from` closes it, with a warning
                yield each
        finally:  # ends the workers, whatever happens
            if finished is not None:
                with warnings.catch_warnings(action="ignore", category=UserWarning):
                    finished.close()  # joblib warns of calls that have not ended


def run_in_order(
    backend: Backend, function: Callable[[JobT], ResultT], jobs: Sequence[JobT]
) -> list[ResultT]:
    """Call the function with every job; return what it returned in the order of the jobs."""
    with closing(backend.run(partial(_numbered, function), list(enumerate(jobs)))) as finished:
        return [result for _, result in sorted(finished, key=itemgetter(0))]


def _numbered(function: Callable[[JobT], ResultT], job: tuple[int, JobT]) -> tuple[int, ResultT]:
    return job[0], function(job[1])


def _call(function: Callable[[JobT], ResultT], job: JobT, parent: int) -> ResultT:
    """A call in a worker, or in the parent itself."""
    end_with(parent)
    return function(job)


@contextmanager
def defer_interrupts() -> Iterator[None]:
    """Hold SIGINT and SIGHUP back while workers start, then deliver them; no worker gets them.

    A process inherits the blocked signals of the thread that starts it. The parent process handles
    them and ends its workers.
    """
    is_main = threading.current_thread() is threading.main_thread()
    if sys.platform == "win32" or not is_main:  # there signals cannot be blocked
        yield
        return
    deferred = signal.SIGINT, signal.SIGHUP  # a terminal sends them to workers too
    start_trackers()  # here, as each unblocks SIGINT where it has to start its process
    came: list[int] = []  # those that another thread took, which does not block them
    before = {n: signal.signal(n, lambda number, _: came.append(number)) for n in deferred}
    blocked = signal.pthread_sigmask(signal.SIG_BLOCK, deferred)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, blocked)
        for number, handler in before.items():
            signal.signal(number, handler)
        if came:
            time.sleep(SETTLE)
            signal.raise_signal(came[0])


def start_trackers() -> None:
    """Start the processes that remove the semaphores of workers when all others have ended.

    joblib's is in a process group of its own: a kill of the command's group leaves it alive.
    """
    stdlib_tracker.ensure_running()
    start = loky_tracker.spawnv_passfds

    def start_in_own_group(path: str, arguments: Sequence[str], files: Sequence[int]) -> int:
        *others, program = arguments
        pid: int = start(path, [*others, f"import os; os.setpgid(0, 0); {program}"], files)
        return pid

    loky_tracker.spawnv_passfds = start_in_own_group
    try:
        loky_tracker.ensure_running()
    finally:
        loky_tracker.spawnv_passfds = start


@cache
def end_with(parent: int) -> None:
    """Let a worker end within a second of its parent process, which may have been killed by now."""
    if os.getpid() != parent:
        threading.Thread(target=_watch, args=(parent,), daemon=True).start()


def _watch(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(0.5)
    os._exit(1)
