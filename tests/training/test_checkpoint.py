"""Checkpoints: read back as written, and refused where they are damaged; curves of a training."""

import errno
import os
import random

import numpy as np
import pytest
from safetensors.numpy import save_file

from swarm_forage_env.errors import ConfigError
from tests.training.conftest import POINT
from training.checkpoint import (
    LOCK,
    RECORD,
    lock_folder,
    mean_with_interval,
    read_checkpoint,
    write_checkpoint,
)
from training.training_loop import FOLDER, ProgressLogger

IDENTITY = {"seed": "3", "layer": "weighting"}
ARRAYS = {
    "means": np.arange(6, dtype=np.float32).reshape(2, 3) / 7,
    "losses": np.array([[0.1, 0.2]]),
    "rounds": np.array(5),
}


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "checkpoint.safetensors"
    write_checkpoint(path, IDENTITY, [POINT], ARRAYS)
    return path


def same(arrays):
    return arrays.keys() == ARRAYS.keys() and all(
        np.array_equal(array, ARRAYS[name]) for name, array in arrays.items()
    )


def test_of_flipped_bits_none_changes_a_number_in_silence(file):
    content = file.read_bytes()
    chosen = random.Random(4).sample(range(8 * len(content)), 1_000)
    refused = 0
    for bit in chosen:
        changed = bytearray(content)
        changed[bit // 8] ^= 1 << bit % 8
        file.write_bytes(bytes(changed))
        try:
            curve, arrays = read_checkpoint(file, IDENTITY)
        except ConfigError:
            refused += 1
        else:
            assert curve == [POINT], f"bit {bit}"
            assert same(arrays), f"bit {bit}"
    assert refused > 900


def test_what_is_no_checkpoint_is_refused_in_its_first_line(file, tmp_path):
    refused = {"": "Header", '{"seed": "0"}': r"\d+ validation errors for Header\)"}
    refused |= {'{"experiment": {}, "curve": []}': r"1 validation error for Header\)"}  # no hash
    refused |= {'{"experiment": {}, "curve": [], "sha256": ""}': "its content is damaged"}
    for header, told in refused.items():
        save_file(ARRAYS, file, {RECORD: header})
        with pytest.raises(ConfigError, match=rf"cannot be read \(.*{told}") as refusal:
            read_checkpoint(file, IDENTITY)
        assert "\n" not in str(refusal.value)
    for kept in (None, {"other": "text"}):  # no record at all, and none of ours
        save_file(ARRAYS, file, kept)
        with pytest.raises(ConfigError, match=r"cannot be read \(.*; remove it to start again"):
            read_checkpoint(file, IDENTITY)
    with pytest.raises(ConfigError, match="cannot be read"):
        read_checkpoint(tmp_path / "none.safetensors", IDENTITY)


@pytest.mark.parametrize(
    ("identity", "text"),
    [({"seed": "3"}, "layer = weighting, not missing"),
     ({**IDENTITY, "device": "cuda"}, "device = missing, not cuda"),
     ({**IDENTITY, "seed": "4", "layer": "motion"}, "seed = 3, not 4")],
)  # fmt: skip
def test_a_checkpoint_tells_the_first_thing_in_which_its_experiment_differs(file, identity, text):
    with pytest.raises(ConfigError, match=rf"holds an experiment with {text}; name another"):
        read_checkpoint(file, identity)


def test_a_mean_has_an_interval_and_that_of_one_world_is_itself():
    found = mean_with_interval(np.array([1, 2, 3, 10]))
    assert found.low < found.mean == 4.0 < found.high
    alone = mean_with_interval(np.array([3]))
    assert (alone.low, alone.mean, alone.high) == (3.0, 3.0, 3.0)


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


def test_tensorboard_reads_the_curves(tmp_path):
    from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

    with ProgressLogger(tmp_path, "round", lambda _: None) as progress:
        progress.log_scalars(2, {"loss": 0.25, "speed/worlds a second": 4.0})
        progress.log_evaluation(POINT)
    curves = EventAccumulator(str(tmp_path / FOLDER)).Reload()
    found = {
        name: [(each.step, each.value) for each in curves.Scalars(name)]
        for name in curves.Tags()["scalars"]
    }
    assert found == {
        "loss": [(2, 0.25)],
        "speed/worlds a second": [(2, 4.0)],
        "held_back/value": [(3, 0.5)],
        "held_back/es1": [(3, 2.0)],
    }


def test_a_full_disk_is_an_error_of_the_training_that_names_the_file(tmp_path, full_disk):
    def log():
        with ProgressLogger(tmp_path, "round", lambda _: None) as progress:
            for step in range(1_000):
                progress.log_scalars(step, {"loss": 0.25})

    with full_disk(1_000), pytest.raises(OSError, match=r"File too large: .*tfevents"):
        log()


def test_a_folder_is_made_with_those_above_it_and_more_steps_than_asked_leave_none(tmp_path):
    lines = []
    out = tmp_path / "a" / "b"
    with ProgressLogger(out, "round", lines.append, 10, 12):
        pass
    assert lines == ["12 of 10 rounds found, 0 to run"]
    assert len(list((out / FOLDER).iterdir())) == 1
