"""A run that is stopped keeps what its bar has counted, and goes on from there."""

import os
import re
import signal
import sys

import pytest

from tests import processes

COMMAND = (
    "-m", "training.cli", "evaluate", "es1", "nc", "ssgikf", "--episodes=300",
    "--set=task.duration=40", "--workers=2",
)  # fmt: skip


def start(out, **variables):
    options = {"cwd": out.parent, "start_new_session": True}
    return processes.start(*COMMAND, f"--out={out}", variables=variables, **options)


def n_files(out):
    return len(list(out.rglob("*.parquet")))


@pytest.mark.skipif(sys.platform == "win32", reason="SIGHUP")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_what_the_bar_has_counted_is_kept_however_a_run_is_stopped(interruptible, tmp_path, number):
    out, temporary = tmp_path / "out", tmp_path / "temporary"
    temporary.mkdir()
    run = start(out, FORCE_COLOR="1", COLUMNS="120", TMPDIR=str(temporary))
    told = ""
    while not (counts := re.findall(r"([1-9][0-9]*)/600", told)):
        told += run.stderr.read(50)
        assert run.poll() is None, told
    if number == signal.SIGTERM:
        run.terminate()
    else:  # as of a terminal: to its workers too
        os.killpg(run.pid, number)
    told += run.communicate(timeout=60)[1]
    assert run.returncode == 130, told
    assert "Traceback" not in told
    assert "the same command goes on from here" in told
    assert 600 > n_files(out) >= max(map(int, counts))
    assert not list(temporary.glob("swarm-forage-*"))
    again = start(out)
    first = again.stderr.readline()
    os.killpg(again.pid, signal.SIGKILL)
    again.communicate(timeout=60)
    assert f"{n_files(out)} of 600 episodes found in" in first
