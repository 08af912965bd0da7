"""The scores that `list` tells are those that `make scores` measures."""

import json

import pytest

from baselines.evaluation import scores
from swarm_forage_env.registry import SCENARIOS


def test_scores_are_of_scenarios_and_controllers_that_there_are():
    assert set(scores.read_scores()) == set(scores.pairs())
    assert scores.score_of_scenario("es1") == scores.score_of_controller("ssgikf")


def test_a_score_lies_in_its_interval_and_says_how_many_episodes():
    for each in scores.read_scores().values():
        assert each.low is None or each.low <= each.mean <= each.high, each
        assert each.episodes == scores.EPISODES


def test_a_score_is_the_mean_of_its_episodes(tmp_path, monkeypatch):
    short = SCENARIOS["near"].model_copy(update={"name": "short"})
    short = short.model_copy(update={"task": short.task.model_copy(update={"duration": 60.0})})
    monkeypatch.setitem(SCENARIOS._parts, "short", short)
    monkeypatch.setattr(scores, "EPISODES", 2)
    found = scores.measure("short", "nc", tmp_path, workers=1)
    assert (found.scenario, found.controller, found.episodes) == ("short", "nc", 2)
    assert found.mean >= 0.0


@pytest.mark.slow
def test_the_score_of_today_is_the_one_that_is_told(tmp_path):
    told = json.loads(scores.FILE.read_text(encoding="utf-8"))
    kept = next(each for each in told if each["controller"] == "ssgikf")
    assert scores.measure("es1", "ssgikf", tmp_path, workers=1) == scores.Score(**kept)
