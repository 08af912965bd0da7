"""One training at a time in a folder."""

import errno
import os
import socket
import sys

import pytest

from swarm_forage_env.errors import ConfigError
from training.checkpoint import LOCK, lock_folder


def test_who_holds_a_folder_is_named_and_it_is_free_again_afterwards(tmp_path):
    here = f"process {os.getpid()} on {socket.gethostname()} is training there"
    for _ in range(2):
        with lock_folder(tmp_path / "x"):
            with pytest.raises(ConfigError, match=here), lock_folder(tmp_path / "x"):
                pass
            files = sorted(file.name for file in (tmp_path / "x").iterdir())
            assert len(files) == 1


def test_a_folder_is_locked_with_those_above_it_and_where_there_are_no_locks(tmp_path, monkeypatch):
    deep = tmp_path / "a" / "b" / "c"
    with lock_folder(deep):
        assert (deep / LOCK).read_text().startswith(f"{os.getpid()} on ")
    (tmp_path / "file").write_text("")
    with (
        pytest.raises(ConfigError, match="file/x: cannot be written"),
        lock_folder(tmp_path / "file" / "x"),
    ):
        pass

    def no_locks(*given):
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr("fcntl.flock", no_locks)
    with lock_folder(deep):
        pass
    monkeypatch.setitem(sys.modules, "fcntl", None)  # as on Windows
    with lock_folder(deep):
        pass
