"""Threads of a block: each runs its own worlds, and polls for the next run before it sleeps.

Waking a thread takes tens of microseconds, in which one core runs hundreds of robot-steps. A thread
that has run its worlds therefore polls the state in its mailbox for a millisecond.

    ASLEEP -> RUNNING -> POLLING -> RUNNING -> POLLING ...
    POLLING -> ASLEEP     if no run follows, or if another block or function needs the core
    RUNNING -> LEAVING    if the caller has polled for the end as long; the thread then sleeps
"""

import os
import timeit
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor, wait
from functools import cache
from operator import is_
from typing import Any

import numpy as np
from llvmlite import ir
from numba.core import cgutils, config, types
from numba.extending import intrinsic

from swarm_forage_env.arrays import Array, Int64
from swarm_forage_env.compiler import entry_point, kernel, typed_once
from swarm_forage_env.interface import Kernel
from swarm_forage_env.ticks import Arrays

run_chunk: Kernel
"""Free name of `serve`: `run_ticks` of these worlds and layers."""

ASLEEP, POLLING, RUNNING, LEAVING = range(4)
"""States of a thread."""

STATE, N_TICKS, MUST_WAKE = range(3)
"""Words of a mailbox: state, number of ticks to run, and whether the thread must be woken."""

WORDS = 16
"""Words from one mailbox to the next: no two threads write to the same cache line."""

POLLING_S = 1e-3
"""Approximate time for which a thread polls before it sleeps."""

YIELD = "sched_yield" if os.name == "posix" else None
"""Function of the operating system by which a polling thread leaves its core to others."""

Mailbox = Int64[Array, " words"]

Mailboxes = Int64[Array, "threads words"]


@intrinsic  # type: ignore[untyped-decorator]
def polled(_: object, mailbox: types.Array) -> object:
    """Return the state; all that was written before it was set can be read afterwards."""

    def generate(context: Any, builder: ir.IRBuilder, _: object, values: Any) -> ir.Value:  # noqa: ANN401 numba's
        if YIELD:
            kind = ir.FunctionType(ir.IntType(32), ())
            builder.call(cgutils.get_or_insert_function(builder.module, kind, YIELD), ())
        state = context.make_array(mailbox)(context, builder, *values).data
        return builder.load_atomic(state, "acquire", 8)

    return types.int64(mailbox), generate


@intrinsic  # type: ignore[untyped-decorator]
def changed(_: object, mailbox: types.Array, old: object, new: object) -> object:
    """Set the state to `new` if it is `old`, by one atomic instruction; return whether it was."""

    def generate(context: Any, builder: ir.IRBuilder, _: object, values: Any) -> ir.Value:  # noqa: ANN401 numba's
        array, *states = values
        state = context.make_array(mailbox)(context, builder, array).data
        return builder.extract_value(builder.cmpxchg(state, *states, "seq_cst", "seq_cst"), 1)

    return types.boolean(mailbox, types.int64, types.int64), generate


@kernel
def has_changed(mailbox: Mailbox, state: int, n_polls: int) -> bool:
    """Poll until the state is another one; return False if it is still the same at the end."""
    n = 0
    while n < n_polls and polled(mailbox) == state:
        n += 1
    return n < n_polls


def serve(mailbox: Mailbox, arrays: Arrays, first: int, last: int, n_polls: int) -> None:
    """Run the ticks of the worlds first .. last - 1 that the mailbox asks for, run after run.

    `arrays` are the arguments of `run_ticks` before the worlds.
    """
    while True:
        run_chunk(*arrays, first, last, mailbox[N_TICKS])
        if not changed(mailbox, RUNNING, POLLING):
            return
        if not has_changed(mailbox, POLLING, n_polls):
            changed(mailbox, POLLING, ASLEEP)
        if polled(mailbox) == ASLEEP:  # LEAVING: a run, whose end the caller awaits asleep already
            return


@typed_once
@entry_point
def hand_over(mailboxes: Mailboxes, n_ticks: int) -> None:
    """Ask all threads that poll for a run, and note which must be woken for it."""
    for mailbox in mailboxes:
        mailbox[N_TICKS] = n_ticks
        mailbox[MUST_WAKE] = not changed(mailbox, POLLING, RUNNING)


@typed_once
@entry_point
def have_ended(mailboxes: Mailboxes, n_polls: int) -> bool:
    """Poll until all threads have ended their runs; return False if one has not."""
    have = True
    for mailbox in mailboxes:
        have = have and has_changed(mailbox, RUNNING, n_polls)
    return have


@typed_once
@entry_point
def change_all(mailboxes: Mailboxes, old: int, new: int) -> None:
    """Set the state of each thread to `new` where it is `old`."""
    for mailbox in mailboxes:
        changed(mailbox, old, new)


class ThreadTeam:
    """The calling thread and others, each with a chunk of the worlds of a block."""

    _polling: Mailboxes = np.zeros((0, WORDS), np.int64)
    """Mailboxes of the block of this process that ran last: no other threads are to poll."""

    def __init__(self, n_worlds: int, threads: int) -> None:
        self.chunks = chunks(n_worlds, threads)
        self.can_poll = len(self.chunks) > 1 and not config.DISABLE_JIT
        """Whether there are other threads, which can poll."""
        self._process, self._arrays = 0, ()
        self._runs: dict[int, Future[None]] = {}

    def call(self, work: Callable[[int, int], None]) -> None:
        """Call a function with the worlds (first, last + 1) of each chunk, on its thread."""
        first, *others = self.chunks
        if others:
            self._prepare(())
        waiting = [self._pool.submit(work, *chunk) for chunk in others]
        try:
            work(*first)
            for each in waiting:
                each.result()
        except BaseException:
            wait(waiting)  # no thread may still run in these worlds when the error is raised
            raise

    def run(
        self, serve: Kernel, arrays: Arrays, n_ticks: int, work: Callable[[int, int], None]
    ) -> None:
        """Let the others `serve` these arrays while the caller runs as many ticks by `work`."""
        self._prepare((*arrays[0], *arrays[1:]))
        try:
            hand_over(self._mailboxes, n_ticks)
            for k in np.flatnonzero(self._mailboxes[:, MUST_WAKE]).tolist():
                wait([self._runs[k]] if k in self._runs else [])
                self._mailboxes[k, STATE] = RUNNING
                given = self._mailboxes[k], arrays, *self.chunks[k + 1], self._n_polls
                self._runs[k] = self._pool.submit(serve, *given)
            work(*self.chunks[0])
            if not have_ended(self._mailboxes, self._n_polls):
                change_all(self._mailboxes, RUNNING, LEAVING)
                for k in np.flatnonzero(self._mailboxes[:, STATE] == LEAVING).tolist():
                    self._runs[k].result()
        except BaseException:
            wait(self._runs.values())  # as in `call`
            raise

    def _prepare(self, arrays: Arrays) -> None:
        """Let all threads sleep but those of this block that poll for a run on these arrays."""
        if self._process != os.getpid():  # a forked process has no other threads
            n, self._process = len(self.chunks) - 1, os.getpid()
            self._pool, self._runs = ThreadPoolExecutor(n, "swarm-forage"), {}
            self._mailboxes = np.zeros((n * self.can_poll, WORDS), np.int64)
            has_cores = n < (os.cpu_count() or 1)
            self._n_polls = polls_for(POLLING_S) if self.can_poll and has_cores else 0
        is_same = len(arrays) == len(self._arrays) and all(map(is_, arrays, self._arrays))
        if self.can_poll and not (is_same and ThreadTeam._polling is self._mailboxes):
            change_all(ThreadTeam._polling, POLLING, ASLEEP)
            change_all(self._mailboxes, POLLING, ASLEEP)
            self._arrays, ThreadTeam._polling = arrays, self._mailboxes


@cache
def polls_for(seconds: float) -> int:
    """Return the number of polls that take about this long, while no other thread is at work."""
    mailbox, n = np.full((1, WORDS), RUNNING), 200
    have_ended(mailbox, n)  # compiles
    return int(n * seconds / min(timeit.repeat(lambda: have_ended(mailbox, n), number=1))) + 1


def chunks(n_worlds: int, threads: int) -> list[tuple[int, int]]:
    """Return the consecutive worlds of each thread, as (first, last + 1).

    >>> chunks(5, 2)
    [(0, 3), (3, 5)]
    """
    parts = np.array_split(np.arange(n_worlds), min(threads, n_worlds))
    return [(int(part[0]), int(part[-1]) + 1) for part in parts]
