"""Policies come back from files as they were; what does not fit or strangers made is refused."""

import json
import os
import pickle
import struct
import zipfile
from pathlib import Path

import numpy as np
import pytest

from swarm_forage_env.controllers import find_controller
from swarm_forage_env.errors import ConfigError, UnknownNameError
from swarm_forage_env.foraging.scenario import Scenario
from swarm_forage_env.scenarios import find_scenario
from training import policy_file as policies
from training.foreign_file import LARGEST, LARGEST_CARD, LARGEST_ZIP, read_file, reason
from training.learned_weighting import EXCHANGE_NETWORK
from training.policy_card import read_policy_card, save_policy_card
from training.policy_file import layer_card, load_policy, save_policy


def with_weights(file, **changes):
    """The same card with other weights; None takes an array away."""
    policy = load_policy(file)
    arrays = {**policy.weights, **{f"weighting.{name}": a for name, a in changes.items()}}
    kept = {name: array for name, array in arrays.items() if array is not None}
    save_policy(file, kept, policy.card)
    return file


def rewritten(file, path, value):
    """The same policy with one entry of its card's text replaced."""
    card = json.loads(file.with_suffix(".json").read_text())
    *branches, leaf = path
    node = card
    for branch in branches:
        node = node[branch]
    node[leaf] = value
    file.with_suffix(".json").write_text(json.dumps(card))
    return file


def test_a_bare_name_is_a_bundled_policy(policy_file, monkeypatch):
    monkeypatch.setattr(policies, "BUNDLED", policy_file.parent)
    assert load_policy("mine").source == policy_file
    with pytest.raises(UnknownNameError, match="no policy named 'mime', did you mean 'mine'"):
        load_policy("mime")


def arrays_of(**header):
    """A file whose only array is told to be so."""
    text = json.dumps({"weighting.x": {"data_offsets": [0, 2], **header}}).encode()
    return struct.pack("<Q", len(text)) + text + b"12"


@pytest.mark.parametrize(
    "content",
    [b"", b"nonsense", pickle.dumps({"weights": [1.0]}),
     arrays_of(dtype="BF16", shape=[1]), arrays_of(dtype="F32", shape=[2])],
    ids=["empty", "text", "pickle", "a kind of number that NumPy has not", "another length"],
)  # fmt: skip
def test_what_is_no_safetensors_file_is_refused(policy_file, content):
    policy_file.write_bytes(content)
    with pytest.raises(ConfigError, match="not a safetensors file"):
        load_policy(policy_file)


def test_a_policy_without_its_card_is_refused(policy_file):
    policy_file.with_suffix(".json").unlink()
    with pytest.raises(ConfigError, match=r"card .*mine.json: cannot be read"):
        load_policy(policy_file)


def test_the_card_of_other_weights_is_refused(policy_file):
    other = policy_file.with_name("other.safetensors")
    policy = load_policy(policy_file)
    zeros = {name: np.zeros_like(array) for name, array in policy.weights.items()}
    save_policy(other, zeros, policy.card)
    other.replace(policy_file)
    with pytest.raises(ConfigError, match="belongs to other weights"):
        load_policy(policy_file)


@pytest.mark.parametrize(
    ("path", "value", "complaint"),
    [
        (("format",), 2, "format"),
        (("layers",), {}, "layers"),
        (("layers",), {"sensing": {}}, "layers.sensing"),
        (("seed",), "first", "seed"),
        (("note",), "hello", "note"),
        (("layers", "weighting", "sizes", "hidden"), 0, "sizes.hidden"),
    ],
)
def test_a_card_that_is_none_is_refused_with_the_entry_at_fault(
    policy_file, path, value, complaint
):
    with pytest.raises(ConfigError, match=rf"card .*mine.json: .*{complaint}"):
        load_policy(rewritten(policy_file, path, value))


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_weights_that_are_no_numbers_are_refused_when_saved_and_when_loaded(
    policy_file, value, monkeypatch
):
    bad = np.array([value], np.float32)
    with pytest.raises(ConfigError, match=r"'weighting.output.bias' holds NaN or infinity"):
        with_weights(policy_file, **{"output.bias": bad})
    with monkeypatch.context() as unguarded:
        unguarded.setattr(policies, "check_weights", lambda *_: None)
        with_weights(policy_file, **{"output.bias": bad})
    with pytest.raises(ConfigError, match=r"'weighting.output.bias' holds NaN or infinity"):
        load_policy(policy_file)


def test_weights_of_double_precision_are_refused(policy_file):
    with pytest.raises(ConfigError, match="is float64: must be float32"):
        with_weights(policy_file, **{"output.bias": np.zeros(1)})


@pytest.mark.parametrize(
    ("name", "array", "complaint"),
    [
        ("output.bias", None, "'weighting.output.bias' is missing: must be (1,)"),
        ("output.bias", np.zeros(2, np.float32), "is (2,): must be (1,)"),
        ("more", np.zeros(2, np.float32), "is (2,): must be no such array"),
    ],
)
def test_arrays_that_do_not_fit_the_network_are_refused(policy_file, name, array, complaint):
    policy = load_policy(with_weights(policy_file, **{name: array}))
    with pytest.raises(ConfigError) as refusal:
        EXCHANGE_NETWORK.numbers_of(policy)
    assert complaint in str(refusal.value)


def test_an_array_of_no_layer_is_refused(policy_file):
    policy = load_policy(policy_file)
    save_policy(policy_file, {**policy.weights, "x.y": np.zeros(1, np.float32)}, policy.card)
    with pytest.raises(ConfigError, match=r"'x.y' belongs to no layer"):
        load_policy(policy_file)


@pytest.mark.parametrize(
    ("path", "value", "complaint"),
    [
        (("network",), "perceptron", "network 'perceptron', not 'log-odds'"),
        (("sizes",), {"width": 2}, "the sizes width: must be hidden"),
        (("sizes",), {}, "the sizes nothing: must be hidden"),
        (("observes", 1, "name"), "encounter.own_q.nest",
         "observation feature 1 of its weighting was encounter.own_q.nest [m] in training and is"
         " encounter.own_p.nest [m] here"),
        (("observes", 1, "unit"), "cm", "was encounter.own_p.nest [cm] in training"),
        (("observes",), [], "feature 0 of its weighting was missing in training"),
        (("gives",), [{"name": "g.nest", "unit": "weight"}, {"name": "g.prey", "unit": "weight"},
                      {"name": "more", "unit": "m"}],
         "action feature 2 of its weighting was more [m] in training and is missing here"),
        (("gives", 1, "name"), "g.home", "action feature 1 of its weighting was g.home [weight]"),
    ],
)  # fmt: skip
def test_a_policy_made_for_something_else_is_refused_with_what_differs(
    policy_file, path, value, complaint
):
    rewritten(policy_file, ("layers", "weighting", *path), value)
    with pytest.raises(ConfigError) as refusal:
        find_controller(f"learned-weighting:policy={policy_file}")
    assert complaint in str(refusal.value)


def test_a_policy_for_another_layer_is_refused(policy_file):
    layers = {"motion": layer_card("motion", Scenario(), "any", {"hidden": 1})}
    card = load_policy(policy_file).card.model_copy(update={"layers": layers})
    save_policy(policy_file, {"motion.x": np.zeros(1, np.float32)}, card)
    with pytest.raises(ConfigError, match="replaces the motion, not the weighting"):
        EXCHANGE_NETWORK.numbers_of(load_policy(policy_file))


def test_a_card_is_json_that_people_can_read(policy_file):
    text = policy_file.with_suffix(".json").read_text("utf-8")
    assert text == json.dumps(json.loads(text), indent=1) + "\n"


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


def test_a_torchscript_that_would_swell_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr("training.foreign_file.LARGEST", 2**20)
    with zipfile.ZipFile(tmp_path / "m.pt", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("m/data/0", bytes(2**21))
    assert "is not TorchScript (has 2.0 MiB" in refusal(f"torchscript:{tmp_path / 'm.pt'}")


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
