"""Commands with `--backend ray`, on a local cluster that each starts; run by `make test-ray`."""

import json
import os
import signal
from pathlib import Path

import pytest

from tests import processes

pytestmark = [
    pytest.mark.ray,
    pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="reads /proc"),
]

EVALUATE = "evaluate", "es1", "nc", "--physics=kinematic", "--format=json"
LONG = "--episodes=3000", "--set=task.duration=300"


@pytest.fixture
def start(tmp_path, interruptible):
    """Start a command as a process of its own in an empty folder."""
    started = []

    def begin(*arguments):
        command = "-m", "training.cli", *arguments
        started.append(processes.start(*command, cwd=tmp_path, start_new_session=True))
        return started[-1]

    yield begin
    for run in started:
        run.kill()
        run.communicate(timeout=100)


def state(process):
    """The parent of a process; None if it has ended."""
    try:
        letter, parent = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[:2]
    except OSError:
        return None
    return None if letter == "Z" else int(parent)


def offspring(process):
    """The processes below one, as far as they run."""
    parents = {int(each.name): state(each.name) for each in Path("/proc").glob("[0-9]*")}
    found, last = [], {process}
    while last:
        last = {child for child, parent in parents.items() if parent in last}
        found += last
    return found


def in_mid_run(run, folder):
    """The processes of a run that has kept its first episodes, and is at work."""
    assert processes.becomes_true(lambda: run.poll() or [*folder.rglob("*.parquet")], 200.0)
    assert run.poll() is None, run.communicate(timeout=100)[1]
    return offspring(run.pid)


def left_of(ours):
    """What these processes run that have not ended in a minute."""
    processes.becomes_true(lambda: not any(map(state, ours)), 60.0)
    return [command_of(each) for each in ours if state(each)]


def command_of(process):
    """What a process runs; nothing if it has ended."""
    try:
        return Path(f"/proc/{process}/cmdline").read_text()[:200]
    except OSError:
        return ""


def test_a_command_says_on_ray_what_it_says_without(start, tmp_path):
    short = *EVALUATE, "--episodes=4", "--set=task.duration=30"
    messages = []
    for backend in ("ray", "joblib"):
        run = start(*short, f"--out={backend}", f"--backend={backend}")
        stdout, stderr = run.communicate(timeout=300)
        assert run.returncode == 0, stderr
        assert all(line.startswith("swarm-forage: ") for line in stderr.splitlines()), stderr
        messages.append([episode | {"wall_s": 0.0} for episode in json.loads(stdout)])
    assert messages[0] == messages[1]


@pytest.mark.parametrize("stop", [signal.SIGINT, signal.SIGTERM])
def test_a_command_that_is_stopped_ends_its_cluster_in_one_line(start, tmp_path, stop):
    run = start(*EVALUATE, *LONG, "--backend=ray", "--out=out")
    ours = in_mid_run(run, tmp_path / "out")
    assert len(ours) > 3
    if stop is signal.SIGINT:
        os.killpg(run.pid, stop)  # as a terminal does
    else:
        run.send_signal(stop)  # as a scheduler does
    stdout, stderr = run.communicate(timeout=100)
    assert run.returncode == 130, stderr
    assert stdout == ""
    assert stderr.splitlines()[1:] == ["swarm-forage: stopped; the same command resumes from here"]
    assert not left_of(ours)


def test_a_command_that_is_killed_takes_its_workers_along(start, tmp_path):
    """And raylet and server; Ray's agents, which run nothing of ours, take minutes to notice."""
    run = start(*EVALUATE, *LONG, "--backend=ray", "--out=out")
    ours = in_mid_run(run, tmp_path / "out")
    ours = [each for each in ours if "Agent" not in command_of(each)]
    assert len(ours) > 3
    run.kill()
    run.wait(timeout=100)
    assert not left_of(ours)
