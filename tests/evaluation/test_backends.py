"""Backends: each job once, results as they end or in order; workers end with their parent."""

import os
import signal
import time
from pathlib import Path

import pytest
from joblib.externals.loky import get_reusable_executor

from baselines.evaluation.backends import IDLE, JoblibBackend, run_in_order
from tests.processes import becomes_true, run, start


def square(number):
    time.sleep(max(0.0, 0.1 * (3 - number)))
    return number**2


@pytest.mark.parametrize("workers", [1, 2])
def test_every_job_is_called_once_and_in_order_if_asked(workers):
    backend = JoblibBackend(workers)
    assert sorted(backend.run(square, range(4))) == [0, 1, 4, 9]
    assert list(backend.run(square, [])) == []
    assert run_in_order(backend, square, range(4)) == [0, 1, 4, 9]


class Interrupting(tuple):
    """Jobs that send this process SIGINT as they are handed to the workers."""

    def __iter__(self):
        os.kill(os.getpid(), signal.SIGINT)
        return super().__iter__()


@pytest.mark.parametrize("workers", [1, 2])
def test_whoever_needs_no_more_results_is_not_warned(workers):
    """Warnings are errors here; on stderr they would stand beside what a command says."""
    results = JoblibBackend(workers).run(square, range(4))
    assert next(results) in (0, 1, 4, 9)
    results.close()


# On a busy machine joblib's thread may be told to stop before it has looked at its first calls.
@pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")
@pytest.mark.parametrize("masked", [True, False])
@pytest.mark.parametrize("workers", [1, 2])
def test_ctrl_c_while_workers_start_is_not_lost(interruptible, monkeypatch, masked, workers):
    """Nor if another thread takes the signal, as happens where the mask is that of one thread."""
    if not masked:
        monkeypatch.setattr(signal, "pthread_sigmask", lambda *_: set())
    before = signal.getsignal(signal.SIGINT), signal.pthread_sigmask(signal.SIG_BLOCK, [])
    ran = []
    with pytest.raises(KeyboardInterrupt):
        ran.extend(JoblibBackend(workers).run(square, Interrupting(range(100))))
    assert not ran
    assert (signal.getsignal(signal.SIGINT), signal.pthread_sigmask(signal.SIG_BLOCK, [])) == before


def signals_blocked(_):
    return signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, [])


def test_workers_never_get_ctrl_c():
    """Of a terminal, which sends it to all processes of a command."""
    get_reusable_executor().shutdown(wait=True)  # workers of another test
    assert all(JoblibBackend(2).run(signals_blocked, range(4)))


ENDS = """
import warnings

from joblib.externals.loky import reusable_executor

from baselines.evaluation import backends

warnings.simplefilter("error")
backends.run_in_order(backends.JoblibBackend(2), abs, range(4))
print(reusable_executor._executor._timeout)
"""


def test_idle_workers_do_not_end_where_a_job_may_come():
    """A worker that ends of itself as a job comes lets joblib wait for ever under -W error."""
    assert run("-c", ENDS)[0] == f"{IDLE}\n"


NAP = """
import os, time
from baselines.evaluation.backends import JoblibBackend, run_in_order

def nap(_):
    os.write(2, f"{os.getpid()}\\n".encode())
    time.sleep(100.0)

run_in_order(JoblibBackend(2), nap, range(2))
"""


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="reads /proc")
def test_workers_of_every_command_end_with_the_parent_process_that_is_killed():
    """All commands run their calls through a backend: training and benchmark too."""
    command = start("-c", NAP)
    workers = [int(command.stderr.readline()) for _ in range(2)]
    os.kill(command.pid, signal.SIGKILL)
    becomes_true(lambda: not any(map(is_running, workers)), 20.0)
    left = [worker for worker in workers if is_running(worker)]
    for worker in left:
        os.kill(worker, signal.SIGKILL)
    assert not left
    command.communicate(timeout=60)


@pytest.mark.skipif(not Path("/dev/shm").exists(), reason="where Linux keeps semaphores")
def test_a_process_group_that_is_killed_leaves_no_semaphores():
    command = start("-c", NAP, start_new_session=True)
    assert all(command.stderr.readline() for _ in range(2)), "the workers are at work"

    def semaphores():
        return [*Path("/dev/shm").glob(f"sem.loky-{command.pid}-*")]

    assert semaphores()
    os.killpg(command.pid, signal.SIGKILL)
    assert becomes_true(lambda: not semaphores(), 20.0)
    command.communicate(timeout=60)


def test_a_worker_whose_parent_was_killed_before_its_first_call_ends():
    code = "import time; from baselines.evaluation import backends; backends.exit_with_parent(1)"
    run("-c", f"{code}; time.sleep(60)", status=1)


def is_running(process):
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False
