"""The card of a policy of another trainer: what it says of controller and observation."""

from types import SimpleNamespace

import pytest

from swarm_forage_env.controllers import find_controller
from swarm_forage_env.errors import ConfigError
from training import policy_card
from training.policy_card import card_from, read_policy_card, save_policy_card
from training.policy_file import load_policy


class Own:
    """An observation of the user's own."""


HERE = f"{__name__}:Own"


@pytest.mark.parametrize(
    ("observation", "names"),
    [("all", ["all"]), (["near", Own], ["near", HERE]), ((Own(), "near"), [HERE, "near"]),
     (Own, [HERE]), (Own(), [HERE])],
)  # fmt: skip
def test_an_observation_is_told_by_its_name_or_by_the_path_of_its_class(observation, names):
    assert policy_card._names(SimpleNamespace(observation=observation)) == names


@pytest.mark.parametrize(
    ("asked", "told"),
    [("ssgiff", ""), ("ssgiff:beta=0.5", "weighting.beta=0.5"),
     ("ssgiff:beta=0.5,pause=3", "estimator.pause=3.0,weighting.beta=0.5")],
)  # fmt: skip
def test_a_controller_is_told_by_what_differs_from_its_name(asked, told):
    name, _, changes = policy_card._text(find_controller(asked)).partition(":")
    assert (name, sorted(changes.split(","))) == ("ssgiff", told.split(","))


def test_a_controller_of_the_users_own_is_told_by_its_name():
    assert policy_card._text(SimpleNamespace(name="mine", parameters={"a": 1})) == "mine"
    assert policy_card._text(SimpleNamespace(name="ssgiff")) == "ssgiff"


def test_a_card_lies_beside_its_policy_and_is_read_again(tmp_path):
    file = tmp_path / "mine.zip"
    assert read_policy_card(file) is None
    written = save_policy_card(file, "es1", "ssgiff:beta=0.5", learn="motion", decision_period=5)
    assert written == tmp_path / "mine.json"
    card = read_policy_card(file)
    assert (card.format, card.scenario, card.controller) == (1, "es1", "ssgiff:weighting.beta=0.5")
    assert card.keywords["decision_period"] == 5
    assert len(card.observes) > 0
    text = written.read_text("utf-8")
    assert text.endswith("}\n")
    with pytest.raises(ConfigError, match=r"card x: format: .*; take it away, and say what"):
        card_from(text.replace('"format": 1', '"format": 2'), "x")


def test_of_several_errors_of_a_card_the_first_is_told(policy_file, tmp_path):
    beside = policy_file.with_suffix(".json")
    beside.write_text(beside.read_text().replace('"seed": 0', '"seed": "x"'))
    beside.write_text(beside.read_text().replace('"format": 1', '"format": 2'))
    with pytest.raises(ConfigError, match=r"mine.json: format: "):
        load_policy(policy_file)
    written = save_policy_card(tmp_path / "other.zip", "es1", "ssgiff", learn="motion")
    text = written.read_text().replace('"format": 1', '"format": 2')
    with pytest.raises(ConfigError, match=r"card x: format: "):
        card_from(text.replace('"scenario": "es1"', '"scenario": 5'), "x")
