"""When a claim counts as reproduced."""

import math

import numpy as np
import pytest

import baselines.papers.reproduction  # noqa: F401 enters the papers
from baselines.evaluation.statistics import Comparison, Estimate, mann_whitney_p
from baselines.papers.claim_result import above
from baselines.papers.claim_types import (
    INDISTINCT,
    Below,
    Contrast,
    NoDifference,
    Number,
    Order,
    Ratio,
    Share,
    _both,
)
from baselines.papers.experiments import (
    CrossValidatedBest,
    Experiment,
    Pool,
    not_all_recruited,
    on_path,
    recruitment_time,
    sample,
)
from baselines.papers.paper import PAPERS

A, B, C = Experiment("es1", "nc"), Experiment("es1", "ssgikf"), Experiment("es1", "dsgikf")
LOW, HIGH = [10, 11, 12, 13, 14, 15], [30, 31, 32, 33, 34, 35]


@pytest.mark.parametrize(
    ("trips", "reproduced"),
    [([99, 100, 101], True), ([79, 80, 81], True), ([120], True), ([78, 79, 80], False),
     ([121, 122, 123], False), ([60, 79, 98], False)],
)  # fmt: skip
def test_a_number_is_reproduced_within_a_fifth(episodes, trips, reproduced):
    claim = Number("trips", A, 100.0)
    assert claim.judge({A: episodes(A, trips)}).reproduced is reproduced


def test_a_number_of_es1_is_reproduced_within_fifteen_per_cent(episodes):
    results = {A: episodes(A, [81, 82, 83])}
    assert Number("trips", A, 100.0).judge(results).reproduced
    assert not Number("trips", A, 100.0, 0.15).judge(results).reproduced


def test_a_finding_holds_the_mean_and_its_interval(episodes):
    found = Number("trips", A, 12.0).judge({A: episodes(A, LOW)})
    assert (found.claim, found.published, found.ours) == ("trips", 12.0, 12.5)
    assert found.low < 12.5 < found.high


def test_a_bound_holds_the_mean_below_it(episodes):
    assert Below("trips", A, 13.0).judge({A: episodes(A, LOW)}).reproduced
    assert not Below("trips", A, 12.5).judge({A: episodes(A, LOW)}).reproduced


@pytest.mark.parametrize(
    ("share", "reproduced"), [(0.39, False), (0.4, True), (0.8, True), (0.81, False)]
)
def test_a_share_is_reproduced_within_ten_points(episodes, share, reproduced):
    results = {A: episodes(A, LOW, on_path_share=share)}
    assert Share("path", (A,), (0.5, 0.7)).judge(results).reproduced is reproduced


def test_the_share_farthest_off_speaks_for_all(episodes):
    results = {
        A: episodes(A, LOW, on_path_share=0.6),
        B: episodes(B, LOW, on_path_share=0.95),
    }
    found = Share("path", (A, B), (0.5, 0.7)).judge(results)
    assert (found.ours, found.reproduced) == (pytest.approx(0.95), False)


def test_an_order_needs_the_right_direction_and_significance(episodes):
    results = {A: episodes(A, LOW), B: episodes(B, HIGH), C: episodes(C, [9, 10, 12, 13, 15, 17])}
    assert Order("b above a", ((B, A),)).judge(results).reproduced
    assert not Order("a above b", ((A, B),)).judge(results).reproduced
    assert not Order("c above a", ((C, A),)).judge(results).reproduced


def test_an_order_needs_a_p_below_one_in_a_hundred(episodes):
    results = {
        A: episodes(A, [1, 2, 3, 4, 5, 6]),
        B: episodes(B, [4, 5, 6, 7, 8, 9]),  # p = 0.04
        C: episodes(C, [7, 8, 9, 10, 11, 12]),  # p = 0.002
    }
    p = [mann_whitney_p([e.round_trips for e in results[x]], range(1, 7)) for x in (B, C)]
    assert 0.02 < p[0] < 0.05
    assert p[1] < 0.01
    assert not Order("b above a", ((B, A),)).judge(results).reproduced
    assert Order("c above a", ((C, A),)).judge(results).reproduced


def test_numbers_of_es1_are_judged_at_fifteen_per_cent_and_all_others_at_twenty():
    judged = [each for each in PAPERS["social-odometry"]().claims if hasattr(each, "tolerance")]
    found = {(each.text.partition(":")[0], each.tolerance) for each in judged}
    assert found == {("es1", 0.15), ("es2", 0.2), ("es3", 0.2), ("real", 0.2)}


@pytest.mark.parametrize(
    ("difference", "p", "is_above"),
    [(1.0, 0.0099, True), (1.0, 0.01, False), (0.0, 0.001, False), (1.0, None, False)],
)
def test_above_is_a_larger_mean_and_a_p_below_one_in_a_hundred(difference, p, is_above):
    assert above(Comparison(Estimate(difference, None, 9), None, p)) == is_above


def test_seeds_under_which_either_number_is_missing_are_left_out(episodes):
    one, other = [1.0, math.nan, 3.0, math.nan], [5.0, 6.0, math.nan, math.nan]
    numbers = {(A, k): one[k] for k in range(4)} | {(B, k): other[k] for k in range(4)}
    results = {A: episodes(A, [0] * 4), B: episodes(B, [0] * 4)}

    def metric(episode):
        return numbers[Experiment(episode.scenario, episode.controller), episode.seed]

    assert _both(results, A, B, metric) == ([1.0], [5.0])


def test_an_order_of_several_pairs_needs_all_and_shows_the_closest(episodes):
    results = {A: episodes(A, LOW), B: episodes(B, HIGH), C: episodes(C, LOW)}
    found = Order("above", ((B, A), (C, A))).judge(results)
    assert (found.ours, found.reproduced) == (1.0, False)


def test_equal_samples_do_not_differ_and_separate_ones_do(episodes):
    results = {A: episodes(A, LOW), B: episodes(B, HIGH), C: episodes(C, LOW)}
    same = NoDifference("same", A, C).judge(results)
    assert same.reproduced
    assert same.p >= INDISTINCT
    assert not NoDifference("same", A, B).judge(results).reproduced


def test_a_ratio_takes_a_pool_by_its_mean(episodes):
    results = {A: episodes(A, [20, 20]), B: episodes(B, [30, 30]), C: episodes(C, [50, 50])}
    found = Ratio("ratio", Pool((B, C)), A, 2.0).judge(results)
    assert (found.ours, found.reproduced) == (2.0, True)


def test_a_ratio_to_zero_says_nothing(episodes):
    found = Ratio("ratio", B, A, 2.0).judge({A: episodes(A, [0, 0]), B: episodes(B, [1, 2])})
    assert (found.ours, found.low, found.high, found.reproduced) == (None, None, None, False)


def test_who_was_not_recruited_counts_with_the_whole_run(episodes):
    results = {A: episodes(A, [1, 1], recruitment_time_s=[400.0, None])}
    assert sample(results, A, recruitment_time) == [400.0, 1000.0]
    assert sample(results, A, not_all_recruited) == [0.0, 1.0]


def test_a_contrast_compares_seed_by_seed():
    assert Contrast("slopes", (), lambda _: (HIGH, LOW)).judge({}).reproduced
    assert not Contrast("slopes", (), lambda _: (LOW, HIGH)).judge({}).reproduced


def test_the_best_experiment_is_scored_on_seeds_that_did_not_choose_it(episodes):
    """B is best on the even seeds, A on the odd ones: each is scored where it is worse."""
    results = {
        A: episodes(A, [1, 9, 1, 9], on_path_share=0.25),
        B: episodes(B, [8, 2, 8, 2], on_path_share=0.5),
    }
    best = CrossValidatedBest((A, B))
    assert [episode.round_trips for episode in best.draw(results)] == [1, 2, 1, 2]
    assert sample(results, best, on_path) == [0.25, 0.5, 0.25, 0.5]


def test_choosing_among_equals_does_not_flatter(episodes):
    """Of many experiments with the same mean, the best one scores that mean."""
    rng = np.random.default_rng(1)
    experiments = tuple(Experiment("es1", f"ssgiff:beta={beta}") for beta in range(1, 41))
    results = {
        experiment: episodes(experiment, rng.poisson(100, 30).tolist())
        for experiment in experiments
    }
    scored = np.mean(
        [episode.round_trips for episode in CrossValidatedBest(experiments).draw(results)]
    )
    flattered = max(np.mean([e.round_trips for e in each]) for each in results.values())
    assert flattered > 102.5
    assert abs(scored - 100.0) < 2.0


def test_a_single_seed_chooses_and_scores(episodes):
    results = {A: episodes(A, [1]), B: episodes(B, [8])}
    assert [episode.controller for episode in CrossValidatedBest((A, B)).draw(results)] == [
        "ssgikf"
    ]
