"""Backends, which spread the calls of a command over worker processes.

The workers of joblib run on this machine, those of a Ray cluster (`ray_backend`) on its nodes.
Results depend neither on the backend nor on the number of workers.
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

Results = Generator[ResultT, None, None]  # results of calls, in the order in which they end

IDLE = 86_400.0
"""Time after which a worker without a job ends [s].

With joblib's 300 s it may end just as a job arrives. joblib then warns in a thread of its own; if
warnings are errors (`python -W error`), this ends the thread, and the call waits for ever.
"""

SETTLE = 0.1
"""Time for joblib's thread to submit the first calls before a deferred signal is delivered [s].

If the signal arrives earlier, the thread ends with a KeyError and prints its traceback.
"""


@dataclass(frozen=True)
class Backend:
    """Base of backends, which run calls in worker processes."""

    workers: int = 1  # number of calls that run at the same time
    threads: int = 1  # number of threads of each call
    device: Device = field(default="cpu", kw_only=True)  # where the worlds of a call run

    def run(self, function: Callable[[JobT], ResultT], jobs: Sequence[JobT]) -> Results[ResultT]:
        """Call the function with every job; yield each result as soon as its call ends.

        Closing the iterator ends the running calls. BrokenExecutor if workers keep dying.
        """
        raise NotImplementedError


class JoblibBackend(Backend):
    """Backend of worker processes on this machine; a single worker is this process itself."""

    def run(self, function: Callable[[JobT], ResultT], jobs: Sequence[JobT]) -> Results[ResultT]:
        """Call the function with every job; workers end with this process, even if it is killed."""
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
                    finished.close()  # joblib warns about unfinished calls


def run_in_order(
    backend: Backend, function: Callable[[JobT], ResultT], jobs: Sequence[JobT]
) -> list[ResultT]:
    """Call the function with every job; return the results in the order of the jobs."""
    with closing(backend.run(partial(_numbered, function), list(enumerate(jobs)))) as finished:
        return [result for _, result in sorted(finished, key=itemgetter(0))]


def _numbered(function: Callable[[JobT], ResultT], job: tuple[int, JobT]) -> tuple[int, ResultT]:
    return job[0], function(job[1])


def _call(function: Callable[[JobT], ResultT], job: JobT, parent: int) -> ResultT:
    """Call the function in a worker, which ends with its parent, or in the parent itself."""
    exit_with_parent(parent)
    return function(job)


@contextmanager
def defer_interrupts() -> Iterator[None]:
    """Defer SIGINT and SIGHUP while workers start, then deliver them; workers never receive them.

    A process inherits the blocked signals of the thread that starts it. The parent process handles
    both signals and ends its workers.
    """
    is_main = threading.current_thread() is threading.main_thread()
    if sys.platform == "win32" or not is_main:  # signals cannot be blocked there
        yield
        return
    deferred = signal.SIGINT, signal.SIGHUP  # a terminal sends them to workers too
    start_trackers()  # before blocking: a tracker unblocks SIGINT when it starts
    came: list[int] = []  # signals taken by a thread that does not block them
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
    """Start the processes that remove the semaphores of workers after all others have ended.

    joblib's process gets its own process group, so that it survives a kill of the command's group.
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
def exit_with_parent(parent: int) -> None:
    """End this worker within a second of the end of its parent, which may be dead already."""
    if os.getpid() != parent:
        threading.Thread(target=_watch, args=(parent,), daemon=True).start()


def _watch(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(0.5)
    os._exit(1)
