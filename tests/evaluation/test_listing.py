"""What there is, with every number, unit and origin."""

import json

import pytest

from baselines.evaluation import listing, scores
from swarm_forage_env.registry import ORIGINS, SCENARIOS


def parameters(name):
    listed = listing.describe(name)["parameters"]
    return {each["name"]: each for group in listed.values() for each in group}


def test_a_field_is_told_with_value_unit_and_origin():
    radius = parameters("es1")["robot.radius"]
    assert (radius["value"], radius["unit"], radius["origin"]) == (0.035, "m", "published")
    assert radius["meaning"] == "Body radius. TR 6.1"
    assert "faults.liar.conspire" in parameters("es1")


def test_a_number_of_its_own_is_told_with_its_own_origin(tmp_path):
    authors = parameters("waypoints-25-authors")
    assert authors["task.tolerance"]["origin"] == "code"
    assert parameters("waypoints-25")["task.tolerance"]["origin"] == "published"
    robots = parameters("ants2008")["task.n_robots"]
    assert (robots["origin"], robots["meaning"]) == ("published", "Number of robots. ANTS Fig. 3a")
    wary = parameters("dsgiff-penalised")
    assert wary["estimator.message_path"]["origin"] == "set"
    assert wary["estimator.pause"]["origin"] == "derived"
    file = tmp_path / "mine.toml"
    file.write_text('base = "es1"\n[task]\nn_robots = 20\n')
    mine = parameters(str(file))
    assert mine["task.n_robots"]["origin"] == "set"
    assert mine["task.duration"]["origin"] == "published"


def test_origins_are_of_numbers_that_there_are():
    for name, origins in ORIGINS.items():
        own = parameters(name)
        assert all(own[each]["meaning"].endswith(text.partition(" (")[0])
                   for each, text in origins.items())  # fmt: skip


@pytest.mark.parametrize("name", [*SCENARIOS, "nc", "ssgiff"])
def test_every_number_has_a_meaning(name):
    assert all(each["meaning"] for each in parameters(name).values())


def test_a_controller_is_told_with_the_parameters_asked_for():
    assert parameters("ssgiff:beta=0.02")["weighting.beta"]["value"] == 0.02
    layers = listing.describe("ssgiff")["layers"]
    assert layers == {"estimator": "social_odometry", "weighting": "sgiff", "motion": "subsumption"}


def test_a_layer_is_told_with_the_parameters_asked_for(command):
    assert parameters("sgiff:beta=0.02")["weighting.beta"]["value"] == 0.02
    _, stdout, _ = command("list", "sgikf")
    assert stdout.startswith("weighting  sgikf: The gain of an induced Kalman filter")
    assert stdout.endswith("ESTIMATOR+sgikf+MOTION:name=value\n")
    assert "validation_gate" in command("list")[1]


def test_scores_are_of_what_there_is_and_lie_in_their_intervals():
    assert set(scores.read_scores()) == set(scores.pairs())
    assert scores.score_of("es1") == scores.score_of("ssgikf")
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
    stored = json.loads(scores.FILE.read_text(encoding="utf-8"))
    kept = next(each for each in stored if each["controller"] == "ssgikf")
    assert scores.measure("es1", "ssgikf", tmp_path, workers=1) == scores.Score(**kept)
