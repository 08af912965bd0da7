"""Datasets in an object store: the same episodes as in a folder, each once, also after a kill."""

import json
import os
import signal
import sys
from pathlib import Path

import pytest

pytest.importorskip("moto", reason="moto comes with extra `dev`")
import fsspec
import s3fs
from moto.server import ThreadedMotoServer

from tests.processes import becomes_true, run, start

SHORT = "evaluate", "es1", "nc", "--physics=kinematic", "--format=json", "--set=task.duration=20"


def episodes(output):
    return [episode | {"wall_s": 0.0} for episode in json.loads(output)]


@pytest.fixture(scope="module")
def server():
    """A store on this machine, and nowhere else."""
    server = ThreadedMotoServer(ip_address="127.0.0.1", port=0)
    server.start()
    host, port = server.get_host_and_port()
    yield {
        "AWS_ENDPOINT_URL": f"http://{host}:{port}",
        "AWS_ACCESS_KEY_ID": "nobody",
        "AWS_SECRET_ACCESS_KEY": "nothing",
        "AWS_DEFAULT_REGION": "us-east-1",
    }
    server.stop()


@pytest.fixture
def bucket(server, monkeypatch):
    """A store with an empty bucket `swarm`, which this process and its children find."""
    for name, value in server.items():
        monkeypatch.setenv(name, value)
    s3fs.S3FileSystem.clear_instance_cache()
    store = s3fs.S3FileSystem()
    store.mkdir("swarm")
    yield store
    store.rm("swarm", recursive=True)


def test_a_store_keeps_what_a_folder_keeps_and_runs_nothing_twice(command):
    status, local, _ = command(*SHORT, "--episodes=4", "--workers=1", "--out=out")
    assert status == 0
    address = "--out=memory://swarm/x"
    status, output, stderr = command(*SHORT, "--episodes=4", "--workers=2", address)
    assert (status, episodes(output)) == (0, episodes(local))
    assert "0 of 4 episodes found in memory://swarm/x, 4 to run" in stderr
    status, again, stderr = command(*SHORT, "--episodes=4", "--workers=1", address)
    assert (status, again) == (0, output)
    assert "4 of 4 episodes found" in stderr
    names = fsspec.filesystem("memory").find("/swarm/x")
    assert sorted(names) == sorted(
        f"/swarm/x/{file.relative_to('out')}" for file in Path("out").rglob("*.parquet")
    )
    assert not list(Path().glob("memory*"))


def test_a_damaged_object_is_set_aside_and_one_that_is_gone_is_told(command, monkeypatch):
    store = fsspec.filesystem("memory")
    one = (*SHORT, "--episodes=2", "--workers=1", "--out=memory://swarm/y")
    output = command(*one)[1]
    (name, _) = sorted(store.find("/swarm/y"))
    store.pipe_file(name, store.cat_file(name)[:-100])
    status, again, stderr = command(*one)
    assert (status, episodes(again)) == (0, episodes(output))
    assert "1 of 2 episodes found" in stderr
    assert sum(each.endswith(".damaged") for each in store.find("/swarm/y")) == 1
    monkeypatch.setattr(type(store), "find", lambda *_, **__: {})
    status, _, stderr = command(*one)
    assert status == 1
    assert "memory://swarm/y: 2 of 2 episodes no longer exist" in stderr.splitlines()[-1]


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        (("--out=nonsense://x",), "--out nonsense://x: Protocol not known: nonsense"),
        (("--out=s3://nowhere/x",), "--out s3://nowhere/x: cannot be written ("),
    ],
)
def test_what_cannot_be_written_is_refused_in_one_line(command, bucket, options, complaint):
    status, stdout, stderr = command(*SHORT, *options)
    assert (status, stdout, stderr.count("\n")) == (2, "", 1)
    assert complaint in stderr


@pytest.mark.skipif(sys.platform == "win32", reason="process groups")
def test_a_run_that_is_killed_goes_on_from_what_a_store_holds(bucket, tmp_path):
    many = (*SHORT[:-1], "--set=task.duration=300", "--episodes=40", "--workers=2")
    command = "-m", "training.cli", *many

    def kept():
        bucket.invalidate_cache()
        return bucket.find("swarm/x", detail=True)

    broken = start(*command, "--out=s3://swarm/x", cwd=tmp_path, start_new_session=True)
    becomes_true(
        lambda: broken.poll() is not None or any(name.endswith(".parquet") for name in kept()), 200
    )
    os.killpg(broken.pid, signal.SIGKILL)
    broken.communicate(timeout=60)
    before = kept()
    assert 0 < len(before) < 40
    (stored, stderr), (local, _) = (
        run(*command, f"--out={out}", cwd=tmp_path) for out in ("s3://swarm/x", "out")
    )
    assert f"{len(before)} of 40 episodes found in s3://swarm/x" in stderr
    assert episodes(stored) == episodes(local)
    after = kept()
    assert len(after) == 40
    assert all(after[name]["LastModified"] == each["LastModified"] for name, each in before.items())
