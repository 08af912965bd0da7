"""kill -9 of evaluations and trainings at random moments: what is kept in the end is the same."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pyarrow.parquet as pq
import pytest
from safetensors.numpy import load_file

pytestmark = pytest.mark.faults

ROOT = Path(__file__).resolve().parents[2]
EVALUATE = (
    "evaluate", "es1", "nc", "ssgikf", "--episodes=20", "--set=task.duration=200", "--workers=2",
)  # fmt: skip
TRAIN = (
    "train", "weighting", "es1", "--algorithm=cma", "--budget=6", "--every=2", "--worlds=2",
    "--held-back=2", "--population=4", "--workers=1", "--physics=kinematic",
    "--set=task.duration=20",
)  # fmt: skip


def start(out, command):
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    environment.pop("SWARM_CHECK_SHAPES", None)
    return subprocess.Popen(
        [sys.executable, "-m", "training.cli", *command, f"--out={out.name}"],
        cwd=out.parent, env=environment, start_new_session=True,
        stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip


def episodes(out):
    rows = pq.read_table(out).drop_columns("wall_s").to_pylist()
    return sorted(rows, key=lambda row: (row["controller"], row["seed"]))


def policy(out):
    return {name: array.tobytes() for name, array in load_file(out / "best.safetensors").items()}


@pytest.mark.parametrize(("command", "kept"), [(EVALUATE, episodes), (TRAIN, policy)])
def test_a_command_that_is_killed_ends_as_one_that_was_not(
    command, kept, tmp_path, tries, rng, tell
):
    (tmp_path / "whole").mkdir()
    begin = time.monotonic()
    run = start(tmp_path / "whole" / "out", command)
    said = run.communicate()[1]
    assert run.returncode == 0, said
    length, expected = time.monotonic() - begin, kept(tmp_path / "whole" / "out")
    killed = 0
    for attempt in range(tries(10)):
        folder = tmp_path / str(attempt)
        folder.mkdir()
        for _ in range(3):
            run = start(folder / "out", command)
            try:
                run.communicate(timeout=rng.uniform(0.0, length))
            except subprocess.TimeoutExpired:
                os.killpg(run.pid, signal.SIGKILL)
                run.communicate()
                killed += 1
        run = start(folder / "out", command)
        said = run.communicate()[1]
        assert run.returncode == 0, said
        assert kept(folder / "out") == expected
        assert not list((folder / "out").rglob("*.tmp"))
    tell(killed=killed, ended=tries(10), failed=0)
