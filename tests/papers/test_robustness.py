"""What the page on faulty robots says, number by number, on episodes worked by hand."""

import re

import pytest

from baselines.evaluation.statistics import Comparison, Estimate
from baselines.papers import robustness
from baselines.papers.claim_types import Order
from baselines.papers.experiments import Experiment
from baselines.papers.robustness import (
    BODIES,
    FAULTS,
    MESSAGES,
    breaking_share,
    breaks,
    experiment,
    harms,
    sound_trips,
    table,
)

FEW = {"nc": "nc", "ssgikf": "ssgikf", "dsgikf": "dsgikf"}
LIARS, DEAF = "liars, each its own", "deaf"


@pytest.fixture
def of_few(monkeypatch, episodes):
    """Episodes of three rules and two faults, six seeds each: trips of a sound robot."""
    monkeypatch.setattr(robustness, "RULES", FEW)
    monkeypatch.setattr(robustness, "FAULTS", {name: FAULTS[name] for name in (LIARS, DEAF)})

    def make(trips, default=100):
        found = {}
        for rule in FEW:
            for fault in (LIARS, DEAF):
                for share in (0.0, 0.1, 0.2, 0.5):
                    each = trips.get((rule, fault, share), default)
                    key = experiment(rule, fault, share)
                    sound = {} if share == 0.0 else {"sound_robots": 1, "round_trips_sound": each}
                    found[key] = episodes(key, [4 * each if share == 0.0 else 7] * 6, **sound)
        return found

    return make


def test_an_experiment_sets_the_share_and_what_belongs_to_the_fault():
    assert experiment("ssgiff", "deaf", 0.0) == Experiment("es1", "ssgiff:beta=0.001")
    found = {fault: experiment("nc", fault, 0.2).settings for fault in FAULTS}
    assert found["liars, conspiring"] == ("faults.liar.share=0.2", "faults.liar.conspire=place")
    assert found["dead, still talking"] == ("faults.dead.share=0.2", "faults.dead.at=300")
    kinds = ["liar", "liar", "stale", "deaf", "mute", "dead", "worn", "blind"]
    assert [first.split(".")[1] for first, *_ in found.values()] == kinds
    assert tuple(FAULTS) == (*MESSAGES, *BODIES)
    assert BODIES == ("dead, still talking", "worn", "blind")


def test_the_score_is_that_of_a_sound_robot_and_needs_both_numbers_of_them(episodes):
    for numbers, score in (
        ({}, 10.0), ({"sound_robots": 2}, 10.0),
        ({"sound_robots": 2, "round_trips_sound": 30}, 15.0),
    ):  # fmt: skip
        (found,) = episodes(Experiment("es1", "nc"), [40], **numbers)
        assert sound_trips(found) == score


@pytest.mark.parametrize(("left", "broken"), [(0, True), (49, True), (50, False), (99, False)])
def test_a_rule_breaks_below_half_of_what_it_does_without_faults(of_few, left, broken):
    results = of_few({("ssgikf", DEAF, 0.5): left})
    assert breaks(results, "ssgikf", DEAF, 0.5) == broken
    assert breaking_share(results, "ssgikf", DEAF) == (0.5 if broken else None)
    assert breaking_share(results, "ssgikf", LIARS) is None


@pytest.mark.parametrize(("left", "harmful"), [(99, True), (100, False), (101, False)])
def test_a_rule_harms_where_it_does_less_than_silent_robots(of_few, left, harmful):
    results = of_few({("ssgikf", DEAF, 0.2): left})
    assert harms(results, "ssgikf", DEAF, 0.2) == harmful
    assert not harms(results, "ssgikf", DEAF, 0.1)


def test_the_tables_say_what_breaks_first_and_what_each_rule_keeps(of_few):
    trips = {
        ("ssgikf", LIARS, 0.1): 90, ("ssgikf", LIARS, 0.2): 40, ("ssgikf", LIARS, 0.5): 5,
        ("dsgikf", LIARS, 0.1): 80, ("dsgikf", LIARS, 0.2): 30, ("dsgikf", LIARS, 0.5): 20,
        ("nc", LIARS, 0.5): 45, ("nc", DEAF, 0.2): 60, ("dsgikf", DEAF, 0.5): 0,
    }  # fmt: skip
    assert table(of_few(trips)).splitlines() == [
        "| fault | breaks first | at | and keeps there | others that break |",
        "| --- | --- | --- | --- | --- |",
        # at one share, the rule that keeps less is the first
        "| liars, each its own | dsgikf | 20 % | 30 % (30 to 30) | ssgikf (20 %), nc (50 %) |",
        "| deaf | dsgikf | 50 % | 0 % (0 to 0) | none |",
        "",
        "| rule | trips without faults | liars, each its own | deaf |",
        "| --- | --- | --- | --- |",
        "| nc | 100.0 (100.0 to 100.0) | 100 % (100 to 100) | 60 % (60 to 60) |",
        "| ssgikf | 100.0 (100.0 to 100.0) | **40 % (40 to 40)** † | 100 % (100 to 100) |",
        "| dsgikf | 100.0 (100.0 to 100.0) | **30 % (30 to 30)** † | 100 % (100 to 100) |",
    ]


def test_a_ratio_to_nothing_is_written_as_such():
    nothing = Comparison(Estimate(1.0, None, 2), None, None)
    assert robustness._percent(nothing) == "-"
    assert robustness._ratio(nothing) == 0.0
    half = Comparison(Estimate(1.0, None, 2), Estimate(0.5, (0.25, 0.75), 2), 0.2)
    assert robustness._percent(half) == "50 % (25 to 75)"


def test_each_question_is_an_order_of_the_two_experiments_that_it_names():
    for claim in robustness.PAPER.claims:
        assert isinstance(claim, Order)
        assert claim.metric is sound_trips
        if "without faults" in claim.text:
            rule, fault = re.match(r"(.*): without .* \((.*)\)", claim.text).groups()
            pair = experiment(rule, fault, 0.0), experiment(rule, fault, 0.1)
        else:
            better, worse, fault = re.match(r"(.*) above (.*): 20 % (.*)", claim.text).groups()
            pair = experiment(better, fault, 0.2), experiment(worse, fault, 0.2)
        assert claim.pairs == (pair,)


def test_a_figure_shows_the_mean_and_interval_of_each_rule_over_the_share(monkeypatch, of_few):
    monkeypatch.setattr(robustness, "mean_panels", lambda *given, **options: (given, options))
    figure = robustness.OverShare("name", "Caption.", (LIARS, DEAF))
    assert len(figure.experiments) == 2 * 3 * 4
    results = of_few({("ssgikf", LIARS, 0.5): 20})
    (panels, _, caption), options = figure.draw(results, "a command")
    assert list(panels) == [LIARS, DEAF]
    assert list(panels[LIARS]) == list(FEW.values())
    means = panels[LIARS]["ssgikf"]
    assert means.x.tolist() == [0.0, 10.0, 20.0, 50.0]
    for found in (means.mean, means.low, means.high):
        assert found.tolist() == [100.0, 100.0, 100.0, 20.0]
    assert (options, caption.n) == ({"one_y": True}, 6)
