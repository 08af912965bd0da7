"""A run killed at any moment and started again gives the data of an unbroken one."""

import os
import random
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pyarrow.parquet as pq
import pytest

ROOT = Path(__file__).resolve().parents[2]
COMMAND = "evaluate", "es1", "nc", "ssgikf", "--episodes=6", "--set=task.duration=40"


def start(out, workers, *more, **variables):
    environment = os.environ | {"PYTHONPATH": str(ROOT)} | variables
    environment.pop("SWARM_CHECK_SHAPES", None)
    program = sys.executable, "-m", "training.cli", *COMMAND, *more
    return subprocess.Popen(
        [*program, f"--out={out}", f"--workers={workers}"],
        env=environment,
        cwd=out.parent,
        start_new_session=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def finish(out, workers):
    run = start(out, workers)
    stdout, stderr = run.communicate(timeout=300)
    assert run.returncode == 0, stderr
    return stdout


def files(out):
    return {file: file.stat().st_mtime_ns for file in out.rglob("*.parquet")}


def kill_when(run, out, n_files, delay):
    """Kill the run and its workers a moment after so many episodes are there."""
    until = time.monotonic() + 120.0
    while run.poll() is None and len(files(out)) < n_files and time.monotonic() < until:
        time.sleep(0.005)
    time.sleep(delay)
    if run.poll() is None:  # else its number may be another's by now
        os.killpg(run.pid, signal.SIGKILL)
    run.communicate(timeout=60)


def table(out):
    read = pq.read_table(out).drop_columns("wall_s").to_pylist()
    return sorted(read, key=lambda row: (row["controller"], row["seed"]))


@pytest.fixture(scope="module")
def unbroken(tmp_path_factory):
    out = tmp_path_factory.mktemp("unbroken") / "out"
    return finish(out, 2), table(out)


@pytest.mark.skipif(sys.platform == "win32", reason="process groups")
def test_a_run_killed_and_started_again_gives_the_data_of_an_unbroken_run(unbroken, tmp_path):
    moments, out = random.Random(1), tmp_path / "out"
    for n_files in (0, 1, 5, 9):
        run = start(out, workers=2)
        before = files(out)
        kill_when(run, out, n_files, 1.5 * moments.random() if n_files == 0 else 0.0)
        time.sleep(0.3)
        now = files(out)
        assert {file: now[file] for file in before} == before, "nothing is repeated"
    told = finish(out, workers=1)
    stdout, expected = unbroken
    assert told == stdout
    assert table(out) == expected
    assert not list(out.rglob("*.tmp"))
    assert not list(out.rglob("*.damaged"))


MANY = "--episodes=300"


@pytest.mark.skipif(sys.platform == "win32", reason="SIGHUP")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_what_the_bar_has_counted_is_kept_however_a_run_is_stopped(interruptible, tmp_path, number):
    out, temporary = tmp_path / "out", tmp_path / "temporary"
    temporary.mkdir()
    run = start(out, 2, MANY, FORCE_COLOR="1", COLUMNS="120", TMPDIR=str(temporary))
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
    assert 600 > len(files(out)) >= max(map(int, counts))
    assert not list(temporary.glob("swarm-forage-*"))
    again = start(out, 2, MANY)
    first = again.stderr.readline()
    os.killpg(again.pid, signal.SIGKILL)
    again.communicate(timeout=60)
    assert f"{len(files(out))} of 600 episodes found in" in first
