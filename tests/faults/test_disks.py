"""Full disks, disks that cannot be written, and folders that vanish, at each kind of output."""

import re
import shutil
import subprocess
import threading
import time

import pytest

import training.train_command  # noqa: F401 adds its commands
from baselines.cli import run
from tests.faults import commands

pytestmark = pytest.mark.faults

QUICK = "--set=task.duration=20", "--physics=kinematic"
WATCH = "watch", "es1", "nc", "--seconds=1", "--size=400", *QUICK

OUTPUTS = {
    "dataset": ("evaluate", "es1", "nc", "--episodes=4", "--workers=1", *QUICK, "--out={}"),
    "csv and svg": ("evaluate", "es1", "nc", "--episodes=2", "--workers=1", *QUICK, "--out={}",
                    "--plot={}/plot.svg"),
    "pdf": ("plot", "boxplot", "data", "--out={}/plot.pdf"),
    "png": ("plot", "boxplot", "data", "--out={}/plot.png"),
    "still": (*WATCH, "--frame={}/still.png"),
    "gif": (*WATCH, "--video={}/clip.gif"),
    "mp4": (*WATCH, "--video={}/clip.mp4"),
    "replay": (*WATCH, "--html={}/replay.html"),
    "training": (*commands.train("cma", "--budget=2", "--every=1", "--worlds=1", "--population=4",
                                 "--set=task.duration=5"), "--out={}"),
    "claims": ("reproduce", "adaptive-boids", "--episodes=1", "--set=task.duration=1",
               "--workers=1", "--out={}"),
}  # fmt: skip
"""Commands that write into a folder, one for each kind of output."""

SLOW = ("claims", "mp4")


def arguments(output, folder):
    return [each.replace("{}", folder) for each in OUTPUTS[output]]


@pytest.fixture
def command(capsys, monkeypatch, tmp_path):
    """Run a command; its status and what it said on stderr, which holds no traceback."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")

    def call(output, folder="out"):
        capsys.readouterr()
        status = run(arguments(output, folder))
        stderr = capsys.readouterr().err
        assert "Traceback" not in stderr
        return status, stderr

    assert run(["evaluate", "es1", "nc", "--episodes=3", "--workers=1", *QUICK, "--out=data"]) == 0
    return call


def files(folder):
    """All files but locks and curves, by name."""
    found = [
        each for each in folder.rglob("*.*") if each.is_file() and "tensorboard" not in str(each)
    ]
    return {each.relative_to(folder): each.read_bytes() for each in found}


def fill(folder):
    """A file that takes all the room of a disk."""
    filler = folder / "filler"
    try:
        with filler.open("wb", buffering=0) as file:
            while True:
                file.write(bytes(4096))
    except OSError:
        return filler


@pytest.fixture
def disk(tmp_path):
    """Make a disk of so many bytes; the test is skipped where the system does not let us."""
    made = []

    def mounted(size):
        place = tmp_path / f"disk{len(made)}"
        place.mkdir()
        order = ["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(place)]
        if shutil.which("mount") is None or (
            subprocess.run(order, capture_output=True, timeout=60).returncode
        ):
            pytest.skip("no disk can be mounted here")
        made.append(place)
        return place

    yield mounted
    for place in made:
        subprocess.run(["umount", "-l", str(place)], check=True, timeout=60)


@pytest.mark.parametrize("output", OUTPUTS)
def test_a_file_that_may_not_grow_is_whole_or_is_not_there(
    output, command, full_disk, tmp_path, tries, rng, tell
):
    assert command(output)[0] == 0
    whole = files(tmp_path / "out")
    largest = max(map(len, whole.values()))
    refused = 0
    for attempt in range(tries(2 if output in SLOW else 20)):
        folder = f"out{attempt}"
        with full_disk(rng.randrange(largest)):
            status, stderr = command(output, folder)
        assert status in (0, 1, 2)
        if status:
            refused += 1
            assert stderr.strip().splitlines()[-1].startswith("swarm-forage: ")
        assert not [*(tmp_path / folder).rglob("_*.tmp")]
        for name in files(tmp_path / folder).keys() & whole.keys():
            assert (tmp_path / folder / name).stat().st_size > 0
        assert command(output, folder)[0] == 0, "the same command goes on when there is room"
        assert files(tmp_path / folder).keys() == whole.keys()
    tell(tried=attempt + 1, refused=refused, failed=0)


@pytest.mark.parametrize("output", OUTPUTS)
def test_a_disk_that_is_full_or_read_only_is_told_in_one_line(
    output, command, disk, tmp_path, tries, rng, tell
):
    refused = 0
    for _ in range(tries(2 if output in SLOW else 5)):
        place = disk(4096 * rng.randrange(3, 40))
        filler = fill(place)
        status, stderr = command(output, str(place))
        assert status != 0
        assert re.search("No space left on device|disk is full", stderr.splitlines()[-1])
        filler.unlink()
        subprocess.run(["mount", "-o", "remount,ro", str(place)], check=True, timeout=60)
        status, stderr = command(output, str(place))
        assert status != 0
        assert "Read-only file system" in stderr.splitlines()[-1]
        refused += 2
        assert not [*place.rglob("_*.tmp")]
        assert not [each for each in place.rglob("*.*") if each.is_file() and each.name != "lock"]
    tell(tried=refused, refused=refused, failed=0)


@pytest.mark.parametrize("output", OUTPUTS)
def test_a_folder_that_vanishes_is_told_or_made_anew(output, command, tmp_path, tries, rng, tell):
    command(output)
    begin = time.monotonic()
    command(output, "again")
    length = time.monotonic() - begin
    whole, n_refused = files(tmp_path / "out").keys(), 0
    for attempt in range(tries(2 if output in SLOW else 10)):
        place = tmp_path / f"out{attempt}"
        remover = threading.Timer(
            rng.uniform(0.0, length), shutil.rmtree, [place], {"ignore_errors": True}
        )
        remover.start()
        status, stderr = command(output, place.name)
        remover.cancel()
        remover.join(timeout=60)
        if status:
            n_refused += 1
            assert stderr.strip().splitlines()[-1].startswith("swarm-forage: ")
        assert command(output, place.name)[0] == 0
        assert files(place).keys() == whole
    tell(tried=attempt + 1, told=n_refused, failed=0)
