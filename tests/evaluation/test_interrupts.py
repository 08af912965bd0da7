"""Ctrl-C at moments when Python drops exceptions: the command ends all the same."""

import os
import re
import signal
import sys
import time

import pymunk
import pytest

from baselines.evaluation.backends import defer_interrupts
from baselines.evaluation.console import interrupts_raised
from tests import processes

WAIT = 60.0
"""More than an interrupt takes [s]."""


class Finalised:
    """An object that is sent SIGINT as it is freed."""

    def __del__(self):
        signal.raise_signal(signal.SIGINT)
        time.sleep(0.0)


def finalise():
    Finalised()


def free_space():
    """Free a pymunk space, and send SIGINT while Chipmunk calls back into Python."""
    space = pymunk.Space()
    for _ in range(5):
        space.add(pymunk.Circle(space.static_body, 1.0))
    seen = []

    def profile(frame, event, _):
        if event == "call" and frame.f_code.co_name == "ext_cpSpaceShapeIteratorFunc" and not seen:
            seen.append(frame)
            signal.raise_signal(signal.SIGINT)

    sys.setprofile(profile)
    try:
        del space
    finally:
        sys.setprofile(None)
    assert seen


def wait_after(drop):
    with interrupts_raised():
        drop()
        time.sleep(WAIT)


@pytest.mark.parametrize("drop", [finalise, free_space])
def test_ctrl_c_is_raised_soon_after_a_moment_that_would_drop_it(interruptible, drop):
    before = signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM), sys.unraisablehook
    with pytest.raises(KeyboardInterrupt):
        wait_after(drop)
    after = signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM), sys.unraisablehook
    assert after == before


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGHUP])
def test_a_process_that_ignores_a_signal_goes_on_to_ignore_it(interruptible, number):
    """As a job that a shell runs in the background, and one that nohup runs."""
    before = signal.signal(number, signal.SIG_IGN)
    with interrupts_raised(), defer_interrupts():
        signal.raise_signal(number)
    signal.signal(number, before)
    with pytest.raises(KeyboardInterrupt), interrupts_raised():
        signal.raise_signal(signal.SIGTERM)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGHUP])
def test_a_signal_that_comes_while_workers_start_is_raised_after(interruptible, number):
    moments = []

    def start():
        with interrupts_raised(), defer_interrupts():
            signal.raise_signal(number)
            moments.append("started")

    with pytest.raises(KeyboardInterrupt):
        start()
    assert moments == ["started"]


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_other_exceptions_of_a_finaliser_are_told_as_ever(monkeypatch):
    output = []
    monkeypatch.setattr(sys, "unraisablehook", output.append)

    class Raising:
        def __del__(self):
            raise ZeroDivisionError

    with interrupts_raised():
        Raising()
    assert [each.exc_type for each in output] == [ZeroDivisionError]


COMMAND = (
    "-m", "training.cli", "evaluate", "es1", "nc", "ssgikf", "--episodes=300",
    "--set=task.duration=40",
)  # fmt: skip


def start(out, workers, **variables):
    options = {"cwd": out.parent, "start_new_session": True}
    command = *COMMAND, f"--workers={workers}", f"--out={out}"
    return processes.start(*command, variables=variables, **options)


def is_gone(group):
    """Whether nobody of a process group is left."""
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return True
    return False


def n_files(out):
    return len(list(out.rglob("*.parquet")))


@pytest.mark.skipif(sys.platform == "win32", reason="process groups")
@pytest.mark.parametrize(
    ("number", "workers"), [(signal.SIGINT, 1), (signal.SIGINT, 2), (signal.SIGTERM, 2)]
)
def test_what_the_bar_has_counted_is_kept_however_a_run_is_stopped(
    interruptible, tmp_path, number, workers
):
    out, temporary = tmp_path / "out", tmp_path / "temporary"
    temporary.mkdir()
    run = start(out, workers, FORCE_COLOR="1", COLUMNS="120", TMPDIR=str(temporary))
    output = ""
    while not (counts := re.findall(r"([1-9][0-9]*)/600", output)):
        output += run.stderr.read(50)
        assert run.poll() is None, output
    if number == signal.SIGTERM:
        run.terminate()
    else:  # as of a terminal: to its workers too
        os.killpg(run.pid, number)
    output += run.communicate(timeout=60)[1]
    assert run.returncode == 130, output
    assert "Traceback" not in output
    assert "swarm-forage: stopped; the same command resumes from here\n" in output
    assert processes.becomes_true(lambda: is_gone(run.pid), 10.0), "its workers too"
    assert 600 > n_files(out) >= max(map(int, counts))
    assert not list(temporary.glob("swarm-forage-*"))
    again = start(out, workers)
    first = again.stderr.readline()
    os.killpg(again.pid, signal.SIGKILL)
    again.communicate(timeout=60)
    assert f"{n_files(out)} of 600 episodes found in" in first
