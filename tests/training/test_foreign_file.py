"""Files that strangers may have made, in every format: too large, no files, or damaged."""

import os
import zipfile
from pathlib import Path

import pytest

from swarm_forage_env.controllers import find_controller
from swarm_forage_env.errors import ConfigError, UnknownNameError
from swarm_forage_env.scenarios import find_scenario
from training.foreign_file import LARGEST, LARGEST_CARD, LARGEST_ZIP, check_zip, read_file, reason
from training.policy_card import read_policy_card, save_policy_card

NAMES = {
    "sb3": "sb3:{}.zip",
    "torchscript": "torchscript:{}.pt",
    "onnx": "onnx:{}.onnx",
    "safetensors": "learned-weighting:policy={}.safetensors",
}


def refusal(name):
    """What is said of a controller that cannot be used, in one line of no great length."""
    with pytest.raises((ConfigError, UnknownNameError)) as refused:
        find_controller(name).check_usable(find_scenario("es1"))
    assert str(refused.value).isprintable()
    assert len(str(refused.value)) < 700
    return str(refused.value)


@pytest.mark.parametrize("name", NAMES.values(), ids=NAMES)
def test_a_name_that_no_file_can_have_is_refused(name):
    assert any(
        each in refusal(name.format("x" * 5000))
        for each in ("there is no such file", "cannot be read (File name too long)")
    )


@pytest.mark.parametrize("kind", NAMES)
def test_a_file_that_is_too_large_is_refused_before_it_is_read(kind, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    largest = LARGEST_ZIP if kind == "sb3" else LARGEST
    with open(f"m{NAMES[kind].partition('{}')[2]}", "wb") as stream:
        stream.truncate(largest + 1)
    assert f"MiB; at most {largest // 2**20} MiB are read" in refusal(NAMES[kind].format("m"))


def test_a_torchscript_that_would_swell_is_refused(tmp_path):
    with (
        zipfile.ZipFile(tmp_path / "m.pt", "w", zipfile.ZIP_DEFLATED) as archive,
        archive.open("m/data/0", "w") as member,
    ):
        for _ in range(257):
            member.write(bytes(2**20))
    assert "is no TorchScript (has 257.0 MiB" in refusal(f"torchscript:{tmp_path / 'm.pt'}")
    with pytest.raises(ValueError, match=r"has 257\.0 MiB; at most 256 MiB are read"):
        check_zip((tmp_path / "m.pt").read_bytes())


def test_a_card_is_read_through_a_link_and_must_be_a_file_of_some_size(tmp_path):
    written = save_policy_card(tmp_path / "one.pt", "es1", decision_period=4)
    (tmp_path / "two.json").symlink_to(written)
    assert read_policy_card(tmp_path / "two.pt") == read_policy_card(tmp_path / "one.pt")
    (tmp_path / "gone.json").symlink_to(tmp_path / "nowhere")
    with pytest.raises(ConfigError, match=r"card .*gone.json: cannot be read \(No such file"):
        read_policy_card(tmp_path / "gone.pt")
    os.mkfifo(tmp_path / "pipe.json")
    with pytest.raises(ConfigError, match=r"cannot be read \(it is no regular file\)"):
        read_policy_card(tmp_path / "pipe.pt")
    os.truncate(written, LARGEST_CARD + 1)
    with pytest.raises(ConfigError, match=r"card .*one.json: has 2.0 MiB; at most 2 MiB are read"):
        read_policy_card(tmp_path / "one.pt")


def test_a_file_whose_size_nobody_tells_is_read_to_the_limit():
    with pytest.raises(ConfigError, match=r"card /proc/self/maps: has .* at most"):
        read_file(Path("/proc/self/maps"), "card", 10)


def test_of_an_error_the_first_line_is_told_as_far_as_it_can_be_shown():
    assert reason(ValueError(" first\nsecond")) == "first"
    assert reason(ValueError("a\x1b[2Jb")) == "a[2Jb"
    assert reason(ValueError("x" * 300)) == "x" * 200 + "..."
    assert reason(EOFError()) == "EOFError"
