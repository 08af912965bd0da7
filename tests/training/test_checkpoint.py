"""Checkpoints: read back as written, and refused in one line where they are damaged."""

import json
import random

import numpy as np
import pytest
from safetensors import safe_open
from safetensors.numpy import save_file

from swarm_forage_env.errors import ConfigError
from training.checkpoint import ANY, RECORD, read_checkpoint, write_checkpoint
from training.policy_file import CurvePoint, Interval

IDENTITY = {"seed": "3", "layer": "weighting"}
POINT = CurvePoint(
    step=3, simulated_s=1.0, value=0.5, round_trips={"es1": Interval(low=1.0, mean=2.0, high=3.0)}
)
ARRAYS = {
    "means": np.arange(6, dtype=np.float32).reshape(2, 3) / 7,
    "losses": np.array([[0.1, 0.2]]),
    "rounds": np.array(5),
}
WANTED = {"means": (ANY, 3), "losses": (ANY, 2), "rounds": ()}


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "checkpoint.safetensors"
    write_checkpoint(path, IDENTITY, [POINT], ARRAYS)
    return path


def same(arrays):
    return arrays.keys() == ARRAYS.keys() and all(
        np.array_equal(array, ARRAYS[name]) for name, array in arrays.items()
    )


def test_a_checkpoint_is_read_as_it_was_written(file):
    curve, arrays = read_checkpoint(file, IDENTITY, WANTED)
    assert curve == [POINT]
    assert same(arrays)


@pytest.mark.parametrize(
    ("name", "shape", "told"),
    [
        ("means", (ANY, 4), r"array 'means' is \(2, 3\): must be \(-1, 4\)"),
        ("losses", (2,), r"array 'losses' is \(1, 2\): must be \(2,\)"),
        ("weights", (3,), r"array 'weights' is missing"),
    ],
)
def test_arrays_of_another_shape_are_refused(file, name, shape, told):
    with pytest.raises(ConfigError, match=rf"{told}.* remove it to start anew"):
        read_checkpoint(file, IDENTITY, {**WANTED, name: shape})


def test_of_flipped_bits_none_changes_a_number_in_silence(file):
    content = file.read_bytes()
    chosen = random.Random(4).sample(range(8 * len(content)), 1_000)
    refused = 0
    for bit in chosen:
        changed = bytearray(content)
        changed[bit // 8] ^= 1 << bit % 8
        file.write_bytes(bytes(changed))
        try:
            curve, arrays = read_checkpoint(file, IDENTITY, WANTED)
        except ConfigError:
            refused += 1
        else:
            assert curve == [POINT], f"bit {bit}"
            assert same(arrays), f"bit {bit}"
    assert refused > 900


def test_a_checkpoint_of_an_older_version_has_no_hash_and_is_read(file):
    with safe_open(file, "np") as kept:
        header = json.loads(kept.metadata()[RECORD])
    del header["sha256"]
    save_file(ARRAYS, file, {RECORD: json.dumps(header)})
    assert same(read_checkpoint(file, IDENTITY, WANTED)[1])
