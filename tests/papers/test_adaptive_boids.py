"""The claims on adaptive boids, and boids where robots forage."""

import math
from dataclasses import replace

import numpy as np
import pytest

from baselines.papers import adaptive_boids, boids_foraging
from baselines.papers.adaptive_boids import (
    ESTIMATORS,
    MEASURES,
    PUBLISHED_SIZES,
    RULES,
    SIZES,
    AllMeansMatch,
    MeanMatches,
    NoDivergence,
    boids_experiment,
    claims,
    deviation,
    published,
)
from baselines.papers.paper import PAPERS
from swarm_forage_env.waypoints.episode import WaypointEpisode

EPISODE = WaypointEpisode(
    "waypoints-10-authors", "boids-goal", 0, "kinematic", 10, 100.0,
    covariance_norm=0.05, position_error_m=0.1, largest_error_m=0.5,
    goals_per_robot=2.0, false_goals_per_robot=1.0, success_rate=2 / 3, wall_s=0.0,
)  # fmt: skip


def as_published(shift=0.0):
    """Trials of every experiment whose means are the published ones, and more by so many sd."""
    results = {}
    for setting in ("authors", "corrected"):
        for estimator in ESTIMATORS:
            for rule in RULES:
                for size in SIZES:
                    theirs = published().get((estimator, rule, size))
                    theirs = theirs or published()[estimator, rule, 10]
                    trials = []
                    for sign in (-1.0, 1.0):
                        numbers = {
                            each.field: (theirs[each.column][0] + (shift + 0.1 * sign)
                                         * theirs[each.column][1]) / each.factor
                            for each in MEASURES
                        }  # fmt: skip
                        trials.append(replace(EPISODE, **numbers))
                    results[boids_experiment(setting, estimator, rule, size)] = trials * 50
    return results


def test_all_published_means_are_known_and_nothing_else():
    assert len(published()) == 27
    assert sorted({size for *_, size in published()}) == list(PUBLISHED_SIZES)
    mean, sd = published()["dead_reckoning", "goal", 5]["cov"]
    assert (mean, sd) == (12.8511, 3.8345)


def test_the_published_means_are_met_by_themselves_and_by_nothing_far_from_them():
    near, far = as_published(), as_published(shift=0.5)
    met = [claim for claim in claims() if isinstance(claim, MeanMatches)]
    assert len(met) == 108
    assert all(claim.judge(near).reproduced for claim in met)
    assert not any(claim.judge(far).reproduced for claim in met)
    together = next(claim for claim in claims() if isinstance(claim, AllMeansMatch))
    assert together.judge(near).reproduced
    assert not together.judge(far).reproduced


def test_a_deviation_is_in_standard_errors_of_both_samples():
    ours = np.array([1.0, 3.0] * 50)
    assert deviation(ours, 1.0, 0.0) == pytest.approx(1.0 / 0.1)
    assert deviation(ours, 1.0, 1.0) == pytest.approx(1.0 / math.hypot(0.1, 0.1))


def test_one_lost_robot_is_a_divergence():
    claim = next(each for each in claims() if isinstance(each, NoDivergence))
    results = as_published()
    assert claim.judge(results).reproduced
    experiment = claim.experiments[0]
    for lost in ({"largest_error_m": 11.0}, {"largest_error_m": math.nan}):
        spoilt = results | {experiment: [replace(EPISODE, **lost), *results[experiment][1:]]}
        found = claim.judge(spoilt)
        assert not found.reproduced
        assert found.ours == 1.0


def test_the_runs_behind_the_figures_had_another_tolerance_in_three_cells():
    wide = [
        experiment for experiment in PAPERS["adaptive-boids"]().experiments
        if "authors" in experiment.controller and experiment.settings
    ]  # fmt: skip
    assert {experiment.scenario for experiment in wide} == {"waypoints-50-authors"}
    assert all(experiment.controller.startswith("boids-adaptive") for experiment in wide)
    assert len(wide) == 3


@pytest.mark.parametrize("paper", [adaptive_boids, boids_foraging])
def test_every_experiment_of_a_paper_can_be_set_up(paper):
    name = "adaptive-boids" if paper is adaptive_boids else "boids-foraging"
    made = PAPERS[name]()
    for experiment in made.experiments:
        configuration = experiment.configuration(None)
        assert configuration.controller.supports(configuration.scenario)


def test_where_nobody_claims_a_goal_nothing_is_said_of_the_success():
    results = {
        experiment: [replace(each, success_rate=None) for each in trials]
        for experiment, trials in as_published().items()
    }
    told = [claim.judge(results) for claim in claims()]
    silent = [each for each in told if each.ours is None]
    assert not any(each.reproduced for each in silent)
    assert any("root mean square" in each.claim for each in silent)
    assert any(each.published == "> 1" for each in silent), "an order"
    assert len(silent) < len(told)
