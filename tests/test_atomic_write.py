"""Atomic writing: whole or not at all, and nothing left over."""

import errno
import os

import pytest

from swarm_forage_env.atomic_write import replacing, sweep, temporary_of, write_atomically


def test_a_file_and_its_folder_are_made_and_replaced(tmp_path):
    file = tmp_path / "deep" / "down" / "x.txt"
    for content in (b"one", b"two"):
        write_atomically(file, content)
        assert file.read_bytes() == content
    assert list(file.parent.iterdir()) == [file]


def test_on_a_full_disk_the_older_file_stays_and_the_error_names_it(tmp_path, full_disk):
    file = tmp_path / "x.txt"
    write_atomically(file, b"older")
    with full_disk(100), pytest.raises(OSError, match=r"x\.txt") as told:
        write_atomically(file, b"newer" * 100)
    assert told.value.errno == errno.EFBIG
    assert file.read_bytes() == b"older"
    assert list(tmp_path.iterdir()) == [file]


def test_a_file_that_no_content_was_written_to_does_not_appear(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"x\.txt"), replacing(tmp_path / "x.txt"):
        pass
    assert not list(tmp_path.iterdir())


def test_an_error_while_writing_leaves_nothing(tmp_path):
    def stopped():
        with replacing(tmp_path / "x.txt") as temporary:
            temporary.write_bytes(b"half")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        stopped()
    assert not list(tmp_path.iterdir())


def test_leftovers_are_swept_by_the_name_of_their_file(tmp_path):
    gone = temporary_of(tmp_path / "x.txt")
    kept = temporary_of(tmp_path / "other.txt"), tmp_path / "_x.txt.tmp"
    for each in (gone, *kept):
        each.write_bytes(b"")
    os.mkdir(tmp_path / "_x.txt.host-1.tmp")
    sweep(tmp_path, r"x\.txt")
    assert not gone.exists()
    assert all(each.exists() for each in kept)
    assert (tmp_path / "_x.txt.host-1.tmp").is_dir()
