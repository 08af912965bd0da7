"""The card of a policy of another trainer: what it says of controller and observation."""

import json
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest
from stable_baselines3 import PPO

from swarm_forage_env.controllers import find_controller
from swarm_forage_env.envs.config import EnvConfig
from swarm_forage_env.errors import ConfigError, UnknownNameError
from swarm_forage_env.scenarios import find_scenario
from swarm_forage_env.spaces import Feature
from swarm_forage_env.task import task_of
from training.policy import FunctionPolicy
from training.policy_card import card_from, read_policy_card, save_policy_card
from training.policy_controller import policy_controller
from training.vec_env import SwarmVecEnv


class Own:
    """An observation of the user's own."""

    def features(self, scenario, agents):
        return [Feature("own", "m", 0.0, 1.0)]

    def write(self, context, out):
        out[...] = 0.0


def test_a_card_lies_beside_its_policy_and_is_read_again(tmp_path):
    file = tmp_path / "mine.zip"
    assert read_policy_card(file) is None
    written = save_policy_card(file, "es1", "ssgiff:beta=0.5", learn="motion", decision_period=5)
    assert written == tmp_path / "mine.json"
    card = read_policy_card(file)
    assert (card.format, card.scenario, card.controller) == (2, "es1", "ssgiff:weighting.beta=0.5")
    assert card.keywords.decision_period == 5
    assert len(card.observes) > 0
    text = written.read_text("utf-8")
    assert text.endswith("}\n")
    wrong = text.replace('"format": 2', '"format": 3').replace('"scenario": "es1"', '"scenario": 5')
    with pytest.raises(ConfigError, match=r"card x: format: .*; remove it, and give the key"):
        card_from(wrong, "x")  # the first of its errors is told


@pytest.mark.parametrize(
    ("scenario", "asked", "then"),
    [
        ("es1", {}, {"action": "drive-v1", "reflexes": False, "walk": False}),
        ("es1", {"action": "wheels"}, {"action": "wheels", "reflexes": False, "walk": False}),
        ("es1", {"residual": True}, {"action": None, "reflexes": False, "walk": False}),
        ("waypoints-05", {}, {"action": None, "reflexes": None, "walk": True}),
    ],
)
def test_a_card_of_version_1_says_what_was_the_default_then(tmp_path, scenario, asked, then):
    text = save_policy_card(tmp_path / "p.pt", scenario, learn="motion", **asked).read_text("utf-8")
    content = json.loads(text)
    content["format"] = 1
    for new in ("reflexes", "walk"):
        del content["keywords"][new]
    keywords = card_from(json.dumps(content), "x").keywords.model_dump()
    assert {name: keywords[name] for name in then} == then


def test_a_policy_that_says_nothing_was_trained_as_environments_are_by_default():
    assert FunctionPolicy().config() == EnvConfig(observation=["layer"])
    assert FunctionPolicy(action="wheels").config().action == "wheels"


@pytest.mark.parametrize(
    ("given", "meant"),
    [(True, True), (False, False), ("true", True), ("false", False), ("3x5", (3, 5)),
     ((2, 4), (2, 4))],
)  # fmt: skip
def test_choices_are_a_few_or_a_grid(given, meant):
    assert FunctionPolicy(discrete=given).discrete == meant


def test_observations_are_told_by_name_and_a_class_of_ones_own_by_its_module():
    assert FunctionPolicy(observation="layer+robot_id").config().observation == [
        "layer",
        "robot_id",
    ]
    assert FunctionPolicy(observation=["layer", Own]).config().observation == ["layer", Own]
    own = FunctionPolicy(observation=f"layer+{__name__}:Own")
    assert own.config().observation == ["layer", Own]
    assert Path(__file__) in own.reads
    for name in ("no_such_module:B", f"{__name__}:Other", ":x"):
        with pytest.raises(ConfigError, match=f"'{name}'"):
            FunctionPolicy(observation=f"layer+{name}").config()


@pytest.mark.parametrize("observation", [["layer", Own], ("layer", Own())])
def test_a_card_cannot_choose_a_class_to_observe_by(tmp_path, observation):
    env = SwarmVecEnv("es1", n_worlds=1, observation=observation)
    PPO("MlpPolicy", env, device="cpu").save(tmp_path / "m.zip")
    with pytest.raises(ConfigError, match=r"if you trust its module, name it: ") as refusal:
        find_controller(f"sb3:{tmp_path / 'm.zip'}")
    find_controller(str(refusal.value).partition("name it: ")[2]).check_usable(find_scenario("es1"))


@pytest.mark.parametrize("size", [0.5, np.zeros(2)])
def test_an_observation_of_a_state_of_its_own_is_not_what_its_class_makes(tmp_path, size):
    own = Own()
    own.size = size
    save_policy_card(tmp_path / "m.pt", "es1", observation=["layer", own])
    (tmp_path / "m.pt").write_bytes(b"")
    for given in ("", f",observation=layer+{__name__}:Own"):
        with pytest.raises(ConfigError, match=rf":Own\(...\) in training, and {__name__}:Own"):
            find_controller(f"torchscript:{tmp_path / 'm.pt'}{given}")


KINDS = {"sb3": "m.zip", "torchscript": "m.pt", "onnx": "m.onnx"}


def write_card_of(folder, **changes):
    """The card of a policy `m` with some of what it says changed."""
    written = save_policy_card(folder / "m.zip", "es1")
    card = json.loads(written.read_text())
    changes["keywords"] = {**card["keywords"], **changes.get("keywords", {})}
    written.write_text(json.dumps({**card, **changes}))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"keywords": {"trust": True}}, r"card .*: keywords.trust: Extra"),
        ({"keywords": {"file": "/etc/passwd"}}, r"card .*: keywords.file: Extra"),
        ({"keywords": {"function": "os:system"}}, r"card .*: keywords.function: Extra"),
        ({"keywords": {"observation": ["os:system"]}}, r"card .*: keywords.observation: Input"),
        ({"keywords": {"observation": "layer+intrusion:Own"}}, "observes by a class of its"),
        ({"keywords": {"learn": "motion\x1b[2J"}}, "no layer to learn named 'motion.x1b"),
        ({"keywords": {"sharpest_turn": float("nan")}}, "card .*: keywords.sharpest_turn: Input"),
        ({"scenario": "es1\nall is well"}, "card .*: scenario: String should match"),
        ({"sizes": [1.0]}, "its card has the sizes of 1 features, not of 45; write it"),
        ({"controller": "sb3:m.zip"}, "'sb3:m.zip': must be of hand-written layers"),
        ({"controller": "callable:intrusion:Own"}, "must be of hand-written layers"),
        ({"controller": "learned-weighting:policy=x.safetensors"}, "must be of hand-written lay"),
        ({"controller": "sikf+learned+boids:policy=x.safetensors"}, "must be of hand-written lay"),
        ({"controller": "ssgiff:motion=learned"}, "must be a name and parameters"),
        ({"controller": "no-error"}, "is a reference that knows the ground truth"),
    ],
)  # fmt: skip
def test_a_card_chooses_no_file_no_code_and_no_trust(kind, changes, message, tmp_path, monkeypatch):
    with zipfile.ZipFile(tmp_path / "m.zip", "w") as archive:
        archive.writestr("data", '{"policy_class": {}, "policy_kwargs": {}}')
        archive.writestr("policy.pth", b"")
    (tmp_path / "m.pt").write_bytes(b"")
    (tmp_path / "m.onnx").write_bytes(b"")
    (tmp_path / "intrusion.py").write_text("class Own:\n    pass\n")
    write_card_of(tmp_path, **changes)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.chdir(tmp_path)
    with pytest.raises((ConfigError, UnknownNameError), match=message) as refusal:
        find_controller(f"{kind}:{KINDS[kind]}").check_usable(find_scenario("es1"))
    assert str(refusal.value).isprintable()
    assert "intrusion" not in sys.modules


def test_what_did_the_rest_is_said_by_the_name_where_a_card_may_not(tmp_path):
    write_card_of(tmp_path, controller="learned-weighting", keywords={"decision_period": 4})
    (tmp_path / "m.pt").write_bytes(b"")
    found = find_controller(f"torchscript:{tmp_path / 'm.pt'},controller=learned-weighting")
    assert (found.layer_names["weighting"], found.policy.decision_period) == ("learned", 4)
    (tmp_path / "w.pt").write_bytes(b"")
    beside = f"torchscript:{tmp_path / 'w.pt'}"
    both = find_controller(f"torchscript:{tmp_path / 'm.pt'},learn=weighting,controller={beside}")
    said = both.assumed(find_scenario("es1"))
    assert "w.pt has no card: assuming learn=motion" in said
    assert "m.pt,beside.decision_period=5" in said
    with pytest.raises(ConfigError, match=r"^controller=sb3: which file\? .*=sb3:model\.zip$"):
        find_controller(f"torchscript:{tmp_path / 'm.pt'},controller=sb3")


def test_nothing_beside_a_function_is_its_card(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("os:getcwd", "os"):
        save_policy_card(tmp_path / name, "es1", learn="weighting")
    assert find_controller("callable:os:getcwd").policy.learn == "motion"


def test_robots_of_a_policy_understand_those_of_the_layers_beside_it():
    scenario = find_scenario("es1")

    def still(seen):
        return np.zeros((len(seen), 2), np.float32)

    for name in ("ssgikf", "dsgiff"):
        language = policy_controller(still, name).language(scenario)
        assert language == find_controller(name).language(scenario)
    everything = policy_controller(still, learn="everything").language(scenario)
    assert everything is task_of(scenario).raw_control
