"""Zips of stable-baselines3 that are not as they should be, and what is read of sound ones."""

import base64
import io
import json
import pickle
import zipfile
from types import SimpleNamespace

import numpy as np
import pytest
import torch
from gymnasium.spaces import Box, Discrete
from stable_baselines3 import PPO

import training.controllers  # noqa: F401 the kinds of policies, also where no package is installed
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.scenarios import find_scenario
from training.sb3_policy import SB3Policy, _check_spaces, _size, _size_of, read_zip
from training.vec_env import SwarmVecEnv

NUMBERS = {"task.n_robots": 4}


def saved(file, **options):
    """An untrained model, in a file."""
    env = SwarmVecEnv("es1", n_worlds=1, physics="kinematic", **NUMBERS)
    made = PPO("MlpPolicy", env, n_steps=8, batch_size=8, seed=0, device="cpu", **options)
    made.save(file)
    return made


def with_parts(file, **changed):
    """The same zip with some of its parts changed; None takes one away."""
    with zipfile.ZipFile(file) as archive:
        parts = {name: archive.read(name) for name in archive.namelist()}
    parts |= {name.replace("_pth", ".pth"): content for name, content in changed.items()}
    with zipfile.ZipFile(file, "w") as archive:
        for name, content in parts.items():
            if content is not None:
                archive.writestr(name, content)


def use(file):
    find_controller(f"sb3:{file}").check_usable(find_scenario("es1", NUMBERS))


def as_torch_saves(what):
    stream = io.BytesIO()
    torch.save(what, stream)
    return stream.getvalue()


class Intruder:
    """What runs when it is unpickled."""

    def __reduce__(self):
        return Intruder.run, ()

    @staticmethod
    def run():
        raise AssertionError("the pickle of a policy was opened")


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (as_torch_saves({"a": Intruder()}), r"its weights cannot be read \(Weights only load"),
        (b"", r"its weights cannot be read \("), (b"junk", r"its weights cannot be read \("),
        (as_torch_saves({"a": torch.zeros(2)}), "its weights do not fit"),
        (as_torch_saves([torch.zeros(2)]), "its weights do not fit"),
        (None, "must be what stable-baselines3's"),
    ],
    ids=["code", "nothing", "junk", "others", "a list", "none"],
)  # fmt: skip
def test_weights_that_are_none_are_refused_and_nothing_of_them_is_run(tmp_path, content, told):
    saved(tmp_path / "m.zip")
    use(tmp_path / "m.zip")
    with_parts(tmp_path / "m.zip", policy_pth=content)
    with pytest.raises(ConfigError, match=told) as refusal:
        use(tmp_path / "m.zip")
    assert str(refusal.value).startswith(f"policy {tmp_path / 'm.zip'}: ")


@pytest.mark.parametrize("data", [None, b"no JSON", b"\xff"], ids=["none", "text", "bytes"])
def test_a_zip_without_what_a_model_tells_of_itself_is_refused(tmp_path, data):
    saved(tmp_path / "m.zip")
    with_parts(tmp_path / "m.zip", data=data)
    with pytest.raises(ConfigError, match="must be what stable-baselines3's"):
        read_zip(tmp_path / "m.zip")


def changed_data(file, **changes):
    data, _ = read_zip(file)
    with_parts(file, data=json.dumps({**data, **changes}).encode())


@pytest.mark.parametrize(
    "told",
    [
        "text", {"__module__": "elsewhere", "__init__": "<function ActorCriticPolicy.__init__ at"},
        {"__module__": "stable_baselines3.common.policies"},
        {"__module__": "stable_baselines3.common.policies",
         "__init__": "<function ActorCriticCnnPolicy.__init__ at 0x1>"},
    ],
)  # fmt: skip
def test_a_class_that_is_not_known_is_not_guessed(tmp_path, told):
    saved(tmp_path / "m.zip")
    changed_data(tmp_path / "m.zip", policy_class=told)
    with pytest.raises(ConfigError, match=r"its policy_class can only .*trust=true"):
        use(tmp_path / "m.zip")


def test_keywords_that_the_class_does_not_take_are_refused(tmp_path):
    saved(tmp_path / "m.zip")
    changed_data(tmp_path / "m.zip", policy_kwargs={"nonsense": 3})
    with pytest.raises(ConfigError, match=r"cannot be made here: .*nonsense"):
        use(tmp_path / "m.zip")


def test_a_model_that_explores_by_its_state_is_one_as_a_controller_too(tmp_path):
    made = saved(tmp_path / "m.zip", use_sde=True)
    controller = find_controller(f"sb3:{tmp_path / 'm.zip'}")
    form = controller.form(find_scenario("es1", NUMBERS))
    observed = np.random.default_rng(0).uniform(-1, 1, (4, len(form.layout))).astype(np.float32)
    found = controller.policy.start(form)(observed)
    np.testing.assert_array_equal(found, made.predict(observed, deterministic=True)[0])


def test_a_file_may_be_named_without_its_ending(tmp_path):
    saved(tmp_path / "m.zip")
    assert SB3Policy(file=str(tmp_path / "m")).path == tmp_path / "m.zip"
    (tmp_path / "n").write_text("")
    assert SB3Policy(file=str(tmp_path / "n")).path == tmp_path / "n"
    with pytest.raises(ConfigError, match=r"policy .*gone: there is no such file"):
        _ = SB3Policy(file=str(tmp_path / "gone")).path
    assert SB3Policy().trust is False


def test_sizes_are_told_of_boxes_choices_and_what_is_neither():
    assert [_size(each) for each in (None, "text", {"n": 5}, {"_shape": [4, 2]}, {"_shape": []})
            ] == ["no", "no", "one of 5 choices", "4x2", "no"]  # fmt: skip
    assert _size_of(Discrete(3)) == "one of 3 choices"
    assert _size_of(Box(-1.0, 1.0, (2, 3))) == "2x3"


def test_numbers_that_differ_from_those_of_the_training_are_all_told():
    form = SimpleNamespace(layout=[0] * 7, action_space=Discrete(3),
                           config=SimpleNamespace(learn="motion"))  # fmt: skip
    spaces = {"observation_space": {"_shape": [5]}, "action_space": {"_shape": [2]}}
    with pytest.raises(ConfigError) as refusal:
        _check_spaces("m.zip", spaces, form)
    assert str(refusal.value) == (
        "policy m.zip: maps 5 numbers to 2; under these keywords (learn=motion) there are 7, and"
        " one of 3 choices. Say what it was trained with, as in"
        " sb3:m.zip,normalise=false,action=wheels"
    )
    _check_spaces("m.zip", {"observation_space": {"_shape": [7]}, "action_space": {"n": 3}}, form)


PICKLE = base64.b64encode(pickle.dumps(Intruder())).decode()
PICKLED = {":type:": "x", ":serialized:": PICKLE}


def with_card(file, **changes):
    """The same model with another card within; `keywords` are added to those of the card."""
    space = read_zip(file)[0]["observation_space"]
    card = json.loads(space["policy_card"])
    changes["keywords"] = {**card["keywords"], **changes.get("keywords", {})}
    changed_data(file, observation_space={**space, "policy_card": json.dumps({**card, **changes})})


@pytest.mark.parametrize("part", ["policy_class", "policy_kwargs"])
def test_no_file_can_say_that_it_is_trusted(tmp_path, part):
    file = tmp_path / "m.zip"
    saved(file)
    with_card(file, keywords={"trust": True})
    changed_data(file, **{part: PICKLED})
    with pytest.raises(ConfigError, match=r"card in .*m.zip: keywords.trust: Extra inputs"):
        use(file)


@pytest.mark.parametrize(
    ("part", "told"),
    [("policy_class", "its policy_class can only be had by unpickling"),
     ("observation_space", "maps no numbers to 2"), ("action_space", r"maps \d+ numbers to no;")],
)  # fmt: skip
def test_a_pickle_in_what_a_model_tells_of_itself_is_not_opened(tmp_path, part, told):
    saved(tmp_path / "m.zip")
    changed_data(tmp_path / "m.zip", **{part: PICKLED})
    with pytest.raises(ConfigError, match=told):
        use(tmp_path / "m.zip")


def test_members_of_a_zip_are_links_to_nothing_and_are_written_nowhere(tmp_path):
    file = tmp_path / "in" / "m.zip"
    file.parent.mkdir()
    saved(file)
    link = zipfile.ZipInfo("policy.pth")
    link.external_attr = 0o120777 << 16
    weights = zipfile.ZipFile(file).read("policy.pth")
    (tmp_path / "weights").write_bytes(weights)
    with_parts(file, policy_pth=None, **{"../over": b"", "/tmp/over": b""})
    with zipfile.ZipFile(file, "a") as archive:
        archive.writestr(link, str(tmp_path / "weights"))
    with pytest.raises(ConfigError, match="its weights cannot be read"):
        use(file)
    assert not (tmp_path / "over").exists()
