"""Atomic writing: whole or not at all, and nothing left over."""

import pytest

from swarm_forage_env.atomic_write import replacing, write_atomically


def test_a_file_and_its_folder_are_made_and_replaced(tmp_path):
    file = tmp_path / "deep" / "down" / "x.txt"
    for content in (b"one", b"two"):
        write_atomically(file, content)
        assert file.read_bytes() == content
    assert list(file.parent.iterdir()) == [file]


def test_a_file_that_no_content_was_written_to_does_not_appear(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"x\.txt"), replacing(tmp_path / "x.txt"):
        pass
    assert not list(tmp_path.iterdir())
