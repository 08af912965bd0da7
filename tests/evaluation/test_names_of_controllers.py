"""Controllers by name: old names, and layers that are put together by their own names."""

import warnings
from typing import ClassVar

import numpy as np
import pytest

from baselines.evaluation.experiment_config import ExperimentConfig
from baselines.weighting import WEIGHTING_RULES
from swarm_forage_env.controllers import find_controller
from swarm_forage_env.errors import UnknownNameError
from swarm_forage_env.parameters import Part, Share
from swarm_forage_env.registry import Registry
from swarm_forage_env.scenarios import find_scenario


class MyRule(Part):
    """A rule from outside: always the same share."""

    heard_p_share: ClassVar[float] = 1.0
    share: Share = 0.25

    def __call__(self, exchange):
        return np.full(exchange.own_p.shape, self.share, np.float32)


@pytest.fixture
def my_rule(monkeypatch):
    """A weighting rule that somebody else has registered."""
    monkeypatch.setattr(WEIGHTING_RULES, "_parts", dict(WEIGHTING_RULES._parts))
    WEIGHTING_RULES.register("my_rule")(MyRule)


def test_an_old_name_is_told_of_once():
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("default")
        for _ in range(3):
            find_controller("dsgiff-wary")
    assert len(told) == 1


def test_a_registry_without_old_names_and_compositions_knows_none():
    registry = Registry("thing")
    registry.register("new")("a thing")
    assert "old" not in registry
    assert "new+new" not in registry
    with pytest.raises(UnknownNameError, match=r"no thing named 'new\+new'"):
        _ = registry["new+new"]


def test_a_composition_of_a_rule_from_outside_is_a_configuration(my_rule):
    text = "social_odometry+my_rule+subsumption:share=0.5"
    controller = find_controller(text)
    configuration = ExperimentConfig(text, find_scenario("es1"), controller)
    assert configuration.parameters == '{"weighting.share": 0.5}'
    other = find_controller("social_odometry+my_rule+subsumption")
    assert ExperimentConfig(text, find_scenario("es1"), other).key != configuration.key


def test_evaluate_runs_a_rule_from_outside(my_rule, monkeypatch, tmp_path, capsys):
    from baselines.cli import run

    monkeypatch.chdir(tmp_path)
    arguments = "--episodes=2", "--set=task.duration=120", "--physics=kinematic", "--workers=1"
    texts = "social_odometry+my_rule+subsumption", "social_odometry+my_rule+subsumption:share=0.9"
    assert run(["evaluate", "es1", *texts, *arguments, "--format=csv"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split(",")[1] for line in lines[1:]] == [texts[0]] * 2 + [texts[1]] * 2
    one, other = (line.split(",")[6:12] for line in (lines[1], lines[3]))
    assert one != other, "the rule is asked, and its parameter counts"
