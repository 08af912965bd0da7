"""The claims on adaptive boids, and boids where robots forage."""

import math
import re
from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from baselines.papers import adaptive_boids
from baselines.papers.adaptive_boids import (
    CLAIMS,
    COVARIANCE,
    ERROR,
    ESTIMATORS,
    GOALS,
    MEASURES,
    PUBLISHED,
    RULES,
    SIZES,
    SUCCESS,
    AllMeansMatch,
    MeanMatches,
    MoreImproved,
    NoDivergence,
    boids_experiment,
    deviation,
)
from baselines.papers.claim_types import Order
from swarm_forage_env.waypoints.episode import WaypointEpisode

EPISODE = WaypointEpisode(
    "waypoints-10-authors", "boids-goal", 0, "kinematic", 10, 100.0,
    covariance_norm=0.05, position_error_m=0.1, largest_error_m=0.5,
    goals_per_robot=2.0, false_goals_per_robot=1.0, success_rate=2 / 3, wall_s=0.0,
)  # fmt: skip


def as_published(shift=0.0):
    """Trials of every experiment whose means are the published ones, and more by so many sd."""
    results = {}
    for setting, *cell in product(("authors", "corrected"), ESTIMATORS, RULES, SIZES):
        estimator, rule, _ = cell
        theirs = PUBLISHED.get(tuple(cell)) or PUBLISHED[estimator, rule, 10]
        trials = []
        for sign in (-1.0, 1.0):
            numbers = {}
            for each in MEASURES:
                mean, sd = theirs[each.column]
                numbers[each.field] = (mean + (shift + 0.1 * sign) * sd) / each.factor
            trials.append(replace(EPISODE, **numbers))
        results[boids_experiment(setting, *cell)] = trials * 50
    return results


def test_all_published_means_are_known_and_nothing_else():
    assert len(PUBLISHED) == 27
    assert sorted({size for *_, size in PUBLISHED}) == [5, 10, 50]
    assert PUBLISHED["dead_reckoning", "goal", 5]["cov"] == (12.8511, 3.8345)


def test_the_published_means_are_met_by_themselves_and_by_nothing_far_from_them():
    near, far = as_published(), as_published(shift=0.5)
    met = [claim for claim in CLAIMS if isinstance(claim, MeanMatches)]
    assert len(met) == 108
    assert all(claim.judge(near).reproduced for claim in met)
    assert not any(claim.judge(far).reproduced for claim in met)
    for claim in (each for each in CLAIMS if isinstance(each, MoreImproved)):
        assert claim.judge(near).reproduced
        assert not replace(claim, places=claim.places[::-1]).judge(near).reproduced


def test_where_nobody_claims_a_goal_nothing_is_said_of_the_success():
    results = {
        experiment: [replace(each, success_rate=None) for each in trials]
        for experiment, trials in as_published().items()
    }
    judged = [claim.judge(results) for claim in CLAIMS]
    silent = {each.claim for each in judged if each.ours is None}
    wanted = {each.claim for each in judged if re.search("success|root mean square", each.claim)}
    assert silent == wanted
    assert not any(each.reproduced for each in judged if each.ours is None)


METRICS = {"covariance norm": COVARIANCE, "mean error [m]": ERROR, "goals per robot": GOALS,
           "success rate [%]": SUCCESS}  # fmt: skip
NAMES = {"dead reckoning": "dead_reckoning", "covariance intersection": "covariance_intersection",
         "decentralised EKF": "decentralised_ekf"}  # fmt: skip


def test_each_order_holds_what_its_words_say_against_each_other():
    for order in (each for each in CLAIMS if isinstance(each, Order)):
        setting, what, sides = order.text.split(": ")
        higher, lower = sides.split(" above ")
        words, _, estimator = what.partition(", ")
        if estimator:
            cells = [(NAMES[estimator], higher, NAMES[estimator], lower)]
        else:
            cells = [(NAMES[higher], rule, NAMES[lower], rule)
                     for rule in ("goal", "static", "adaptive")]  # fmt: skip
        assert order.pairs == tuple(
            (boids_experiment(setting, one, rule, size), boids_experiment(setting, *other, size))
            for one, rule, *other in cells
            for size in SIZES
        )
        assert order.metric is METRICS[words]


def test_an_experiment_is_the_scenario_of_its_size_and_the_tolerance_of_the_paper():
    plain = boids_experiment("authors", "decentralised_ekf", "static", 5)
    assert (plain.scenario, plain.settings) == ("waypoints-05-authors", ())
    assert plain.controller == "boids-static:estimator=decentralised_ekf,setting=authors"
    for setting, rule, size in (("authors", "adaptive", 50), ("corrected", "goal", 5)):
        wide = boids_experiment(setting, "dead_reckoning", rule, size)
        assert wide.settings == ("task.tolerance=0.2",)
    assert boids_experiment("authors", "dead_reckoning", "adaptive", 25).settings == ()
    assert boids_experiment("authors", "dead_reckoning", "goal", 50).settings == ()


def mean_matches(errors, size=10):
    """A claim on a published mean, and trials so many standard errors of the paper's from it."""
    cell = "dead_reckoning", "goal", size
    claim = MeanMatches(cell, ERROR)
    mean, sd = PUBLISHED[cell]["err"]
    value = mean + errors * sd / math.sqrt(100)
    return claim, {claim.experiments[0]: [replace(EPISODE, position_error_m=value)] * 4}


@pytest.mark.parametrize(
    ("errors", "met"), [(-3.01, False), (-2.99, True), (0.0, True), (2.99, True), (3.01, False)]
)
def test_a_published_mean_is_met_within_three_standard_errors(errors, met):
    claim, results = mean_matches(errors)
    assert claim.deviation(results) == pytest.approx(errors)
    assert claim.judge(results).reproduced == met


def test_a_deviation_of_trials_that_vary_is_smaller():
    assert deviation([1.0, 3.0, 1.0, 3.0], 1.0, 10.0) == pytest.approx(1.0 / math.hypot(1.0, 0.5))


@pytest.mark.parametrize("errors", [(1.29, -1.29), (1.31, -1.31), (1.8, 0.0), (1.9, 0.0)])
def test_the_root_mean_square_of_the_deviations_may_be_one_and_a_third(errors):
    parts = [mean_matches(each, size) for each, size in zip(errors, (5, 10), strict=True)]
    judged = AllMeansMatch(tuple(part for part, _ in parts)).judge(parts[0][1] | parts[1][1])
    rms = math.hypot(*errors) / math.sqrt(2.0)
    assert (judged.reproduced, judged.ours) == (rms <= 1.3, pytest.approx(rms))


@pytest.mark.parametrize(
    ("numbers", "n_lost"),
    [({}, 0), ({"largest_error_m": 9.99}, 0), ({"largest_error_m": 10.0}, 2),
     ({"covariance_norm": math.inf}, 2), ({"covariance_norm": math.nan}, 2)],
)  # fmt: skip
def test_who_is_off_by_the_side_of_the_world_has_diverged(numbers, n_lost):
    one, other = (boids_experiment("corrected", "dead_reckoning", "goal", n) for n in (5, 10))
    results = {one: [EPISODE, replace(EPISODE, **numbers)], other: [replace(EPISODE, **numbers)]}
    found = NoDivergence((one, other)).judge(results)
    assert (found.ours, found.published, found.reproduced) == (n_lost, 0.0, n_lost == 0)
    (claim,) = (each for each in CLAIMS if isinstance(each, NoDivergence))
    assert len(set(claim.experiments)) == 36
    assert all("setting=corrected" in each.controller for each in claim.experiments)


@pytest.mark.parametrize(("setting", "number"), [("authors", 4), ("corrected", 7)])
def test_a_figure_shows_means_and_deviations_over_the_density(monkeypatch, number, setting):
    monkeypatch.setattr(adaptive_boids, "mean_panels", lambda *arguments: arguments)
    figures = {each.name: each for each in adaptive_boids.FIGURES}
    figure, measure = figures[f"boids{number}_{setting}"], MEASURES[number - 4]
    results = {
        each: [replace(EPISODE, **{measure.field: value}) for value in (1.0, 3.0)]
        for each in figure.experiments
    }
    nobody = boids_experiment(setting, "decentralised_ekf", "static", 10)
    results[nobody] = [replace(EPISODE, **{measure.field: None})]
    panels, _, caption, *_ = figure.draw(results, "a command")
    factor = 100.0 if measure is SUCCESS else 1.0
    for (words, estimator), rule in product(NAMES.items(), RULES):
        means = panels[words][rule]
        gone = [boids_experiment(setting, estimator, rule, n) == nobody for n in SIZES]
        assert means.x.tolist() == [0.05, 0.1, 0.25, 0.5]  # robots on 100 m2
        for found, value in ((means.mean, 2.0), (means.low, 1.0), (means.high, 3.0)):
            np.testing.assert_allclose(found, np.where(gone, np.nan, value * factor))
        theirs = [PUBLISHED[estimator, rule, n][measure.column][0]
                  if n != 25 and setting == "authors" else np.nan for n in SIZES]  # fmt: skip
        np.testing.assert_array_equal(means.published, theirs)
    assert "n = 2 trials each" in caption.note
