"""The page on faulty robots: its experiments, its verdicts on cases worked by hand, its tables."""

import numpy as np
import pytest

from baselines.papers import report
from baselines.papers.robustness import (
    ALONE,
    CONSPIRING,
    FAULTS,
    LIARS,
    RULES,
    SHARES,
    breaking_share,
    experiment,
    harms,
    robustness,
    sound_trips,
    table,
)

SEEDS = 6


@pytest.fixture
def results(episodes):
    """Episodes of four robots: what each rule brings in under each fault and share of it."""

    def make(trips):
        found = {}
        for rule in RULES:
            for fault in FAULTS:
                for share in (0.0, *SHARES):
                    n_sound = None if share == 0.0 else 2
                    whole = [
                        round(4 * trips(rule, fault, share)) + seed % 2 for seed in range(SEEDS)
                    ]
                    sound = None if share == 0.0 else [each // 2 for each in whole]
                    found[experiment(rule, fault, share)] = episodes(
                        experiment(rule, fault, share), whole,
                        sound_robots=n_sound, round_trips_sound=sound,
                    )  # fmt: skip
        return found

    return make


def test_the_score_is_that_of_a_sound_robot(episodes):
    where = experiment("nc", LIARS, 0.0)
    (whole,) = episodes(where, [40])
    (faulty,) = episodes(where, [40], sound_robots=2, round_trips_sound=30)
    assert sound_trips(whole) == 10.0
    assert sound_trips(faulty) == 15.0


def test_every_experiment_can_be_configured_and_is_another_one():
    paper = robustness()
    assert len(paper.experiments) == len(RULES) * (1 + len(FAULTS) * len(SHARES))
    without_learning = [each for each in paper.experiments if "learned" not in each.controller]
    keys = {each.configuration("kinematic").key for each in without_learning[:40]}
    assert len(keys) == 40
    for fault in FAULTS:
        assert experiment("nc", fault, 0.2).configuration("kinematic").scenario.faults.is_any


def test_a_rule_breaks_where_less_than_half_is_left(results):
    left = {0.0: 100.0, 0.1: 60.0, 0.2: 40.0, 0.5: 20.0}
    found = results(lambda rule, fault, share: left[share] if fault == LIARS else 90.0)
    assert breaking_share(found, "ssgikf", LIARS) == 0.2
    assert breaking_share(found, "ssgikf", CONSPIRING) is None


def test_a_rule_harms_where_silence_does_better(results):
    found = results(lambda rule, fault, share: 50.0 if rule == ALONE else 100.0 - 160.0 * share)
    assert not harms(found, "ssgikf", LIARS, 0.1)
    assert harms(found, "ssgikf", LIARS, 0.5)
    assert not harms(found, ALONE, LIARS, 0.5)


def test_the_page_says_which_rule_breaks_first(results):
    def trips(rule, fault, share):
        if fault == LIARS and share > 0.0:
            return {"dsgikf": 10.0, "ssgikf": 30.0}.get(rule, 90.0)
        return 100.0

    found = results(trips)
    text = table(found)
    assert "| liars, each its own | dsgikf | 10 % | 10 % " in text
    assert "ssgikf (10 %) |" in text
    assert "| liars, conspiring | none |  |  |  |" in text
    assert "**30 % " in text
    paper = robustness()
    page = report.page(paper, paper.judge(found), found, "swarm-forage reproduce robustness")
    assert "$" not in page
    assert "Not in the paper" in page
    names = [each.text for each in paper.claims]
    assert len(set(names)) == len(names)


@pytest.mark.parametrize("best", ["ssgikf-sceptical", "learned-sceptical"])
def test_each_defence_is_held_against_the_one_before_it(results, best):
    def trips(rule, fault, share):
        left = {"ssgikf": 30.0, "ssgikf-sceptical": 60.0, "learned-sceptical": 60.0, best: 90.0}
        return left.get(rule, 50.0) if share > 0.0 else 100.0

    verdicts = {each.claim: each.reproduced for each in robustness().judge(results(trips))}
    for fault in (LIARS, CONSPIRING):
        assert verdicts[f"ssgikf-sceptical above ssgikf: 20 % {fault}"]
        learned = verdicts[f"learned-sceptical above ssgikf-sceptical: 20 % {fault}"]
        assert learned == (best == "learned-sceptical")


def test_both_figures_are_drawn(results):
    for figure in robustness().figures:
        drawn = figure.draw(results(lambda rule, fault, share: 50.0), "a command")
        assert len([axes for axes in drawn.axes if axes.get_title(loc="left")]) == len(
            figure.faults
        )


def test_a_curve_runs_from_no_faulty_robot_to_the_largest_share_in_per_cent(results):
    figure = robustness().figures[0]
    drawn = figure.draw(results(lambda rule, fault, share: 50.0), "a command")
    expected = np.array([0.0, *(100.0 * share for share in SHARES)])
    curves = [line.get_xdata() for line in drawn.axes[0].lines if len(line.get_xdata()) == 4]
    aside = [np.unique(np.round(x - expected, 9)) for x in curves]  # so that none hides another
    assert aside
    assert all(len(each) == 1 and abs(each[0]) < 5.0 for each in aside)
