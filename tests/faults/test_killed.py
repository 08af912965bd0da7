"""kill -9 of every command at random moments: what is kept in the end is the same."""

import os
import signal
import subprocess
import time

import pytest

from tests.faults import commands

pytestmark = pytest.mark.faults

COMMANDS = {
    "evaluate": (commands.EVALUATE, commands.episodes, 25),
    "train_cma": (commands.CMA, commands.policy, 15),
    "train_imitation": (commands.IMITATION, commands.policy, 15),
    "train_ppo": (commands.PPO, commands.policy, 15),
    "benchmark": (commands.BENCHMARK, commands.runs, 15),
    "reproduce": (commands.REPRODUCE, commands.claims, 15),
}
"""What is killed, how its output is read, and how often it is killed where FAULTS is 100."""

STOPPED = 130, -signal.SIGINT
"""Exit status after Ctrl-C: Python ends by the signal if that came within an `exec`, as where numba
compiles; a shell tells 130 of both."""

IN_A_ROW = 5
"""Kills before a command may end."""


def finish(out, command):
    run = commands.start(out, command)
    stderr = run.communicate(timeout=3000)[1]
    assert run.returncode == 0, stderr


def kill(out, command, moment):
    """Kill a command and its workers after so long [s]; False if it had ended before."""
    run = commands.start(out, command)
    try:
        run.communicate(timeout=moment)
        return False
    except subprocess.TimeoutExpired:
        os.killpg(run.pid, signal.SIGKILL)
        run.communicate(timeout=60)
        return True


@pytest.mark.parametrize("name", COMMANDS)
def test_a_command_that_is_killed_ends_as_one_that_was_not(name, tmp_path, tries, rng, tell):
    command, kept, times = COMMANDS[name]
    begin = time.monotonic()
    (tmp_path / "whole").mkdir()
    finish(tmp_path / "whole" / "out", command)
    length, expected = time.monotonic() - begin, kept(tmp_path / "whole" / "out")
    left, ended = tries(times), 0
    while left:
        ended += 1
        folder = tmp_path / str(ended)
        folder.mkdir()
        for _ in range(min(left, IN_A_ROW)):
            left -= kill(folder / "out", command, rng.uniform(0.0, length))
        finish(folder / "out", command)
        assert kept(folder / "out") == expected
        assert not list((folder / "out").rglob("*.tmp"))
    tell(killed=tries(times), ended=ended, failed=0)


def test_threads_that_are_interrupted_end_with_one_line_and_lose_nothing(
    tmp_path, interruptible, tries, rng, tell
):
    command = (*commands.EVALUATE[:-1], "--workers=1", "--threads=4")
    begin = time.monotonic()
    finish(tmp_path / "whole", command)
    length, expected = time.monotonic() - begin, commands.episodes(tmp_path / "whole")
    interrupted = 0
    for attempt in range(tries(20)):
        run = commands.start(tmp_path / str(attempt), command)
        time.sleep(rng.uniform(0.3, 1.0) * length)
        run.send_signal(signal.SIGINT)
        stderr = run.communicate(timeout=60)[1]
        assert run.returncode in (0, *STOPPED), stderr
        interrupted += run.returncode in STOPPED
        assert "Traceback" not in stderr.partition("compiling")[2], stderr
        finish(tmp_path / str(attempt), command)
        assert commands.episodes(tmp_path / str(attempt)) == expected
    assert interrupted, "else nothing was tried"
    tell(tried=tries(20), interrupted=interrupted, failed=0)


def test_ctrl_c_while_workers_start_ends_with_one_line(tmp_path, interruptible, tries, rng, tell):
    """As of a terminal: to the command and its workers."""
    finish(tmp_path / "whole", commands.EVALUATE)
    left, interrupted, expected = tries(20), 0, commands.episodes(tmp_path / "whole")
    while left:
        out = tmp_path / str(left)
        for _ in range(min(left, IN_A_ROW)):
            run, left = commands.start(out, commands.EVALUATE), left - 1
            run.stderr.readline()  # how many episodes are to run
            time.sleep(rng.uniform(0.0, 1.0))
            os.killpg(run.pid, signal.SIGINT)
            stderr = run.communicate(timeout=60)[1]
            assert run.returncode in (0, *STOPPED), stderr
            assert stderr.count("\n") == 1, stderr
            interrupted += run.returncode in STOPPED
        finish(out, commands.EVALUATE)
        assert commands.episodes(out) == expected
    assert interrupted, "else nothing was tried"
    tell(tried=tries(20), interrupted=interrupted, failed=0)
