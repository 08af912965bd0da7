"""When a claim counts as reproduced."""

import math

import pytest

from baselines.evaluation.statistics import Comparison, Estimate
from baselines.papers import claim_types
from baselines.papers.beta_sweep import (
    BETAS,
    BestBeta,
    BetaSweep,
    OptimumInsideRange,
    OtherBetasBelow,
)
from baselines.papers.claim_types import (
    Claim,
    ClaimResult,
    Contrast,
    InRange,
    NoDifference,
    Order,
    above,
    below,
    number,
    present_pairs,
    share,
    within,
)
from baselines.papers.experiments import Experiment, on_path, recruitment_time, round_trips
from baselines.papers.paper import find_paper

A, B, C = Experiment("es1", "nc"), Experiment("es1", "ssgikf"), Experiment("es1", "dsgikf")
LOW, HIGH = [10, 11, 12, 13, 14, 15], [30, 31, 32, 33, 34, 35]


@pytest.mark.parametrize(
    ("trips", "reproduced"),
    [([79, 80, 81], True), ([120], True), ([78, 79, 80], False), ([121, 122, 123], False)],
)
def test_a_number_is_reproduced_within_a_fifth_and_a_ratio_too(episodes, trips, reproduced):
    results = {A: episodes(A, trips), B: episodes(B, [10] * len(trips))}
    found = number("trips", A, 100.0).judge(results)
    assert (found.ours, found.reproduced) == (sum(trips) / len(trips), reproduced)
    assert number("ratio", (A, B), 10.0).judge(results).reproduced is reproduced


def test_a_bound_holds_the_mean_below_it(episodes):
    assert below("trips", A, 13.0).judge({A: episodes(A, LOW)}).reproduced
    assert not below("trips", A, 12.4).judge({A: episodes(A, LOW)}).reproduced


@pytest.mark.parametrize(
    ("level", "reproduced"), [(0.39, False), (0.4, True), (0.8, True), (0.81, False)]
)
def test_a_share_is_reproduced_within_ten_points(episodes, level, reproduced):
    results = {A: episodes(A, LOW, on_path_share=level)}
    assert share("path", (A,), (0.5, 0.7)).judge(results).reproduced is reproduced


def test_an_order_needs_the_right_direction_and_significance(episodes):
    results = {A: episodes(A, LOW), B: episodes(B, HIGH), C: episodes(C, [9, 10, 12, 13, 15, 17])}
    assert Order("b above a", ((B, A),)).judge(results).reproduced
    assert not Order("a above b", ((A, B),)).judge(results).reproduced
    assert not Order("c above a", ((C, A),)).judge(results).reproduced
    assert not Order("both above a", ((B, A), (C, A))).judge(results).reproduced


def test_numbers_of_es1_are_judged_at_fifteen_per_cent_and_all_others_at_twenty():
    claims = [each for each in find_paper("social-odometry").claims if isinstance(each, InRange)]
    found = {
        (each.text.partition(":")[0], round(each.high / each.published - 1.0, 9))
        for each in claims
        if each.metric in {round_trips, recruitment_time} and each.low > 0.0
    }
    assert found == {("es1", 0.15), ("es2", 0.2), ("es3", 0.2), ("real", 0.2)}


@pytest.mark.parametrize(
    ("difference", "p", "is_above"),
    [(1.0, 0.0099, True), (1.0, 0.01, False), (0.0, 0.001, False), (1.0, None, False)],
)
def test_above_is_a_larger_mean_and_a_p_below_one_in_a_hundred(difference, p, is_above):
    assert above(Comparison(Estimate(difference, None, 9), None, p)) == is_above


def test_seeds_under_which_either_number_is_missing_are_left_out(episodes):
    one, other = [1.0, math.nan, 3.0, math.nan], [5.0, 6.0, math.nan, math.nan]
    results = {
        each: episodes(each, [0] * 4, on_path_share=shares)
        for each, shares in ((A, one), (B, other))
    }
    assert present_pairs(results, A, B, on_path) == ([1.0], [5.0])


def test_a_ratio_to_zero_says_nothing(episodes):
    results = {A: episodes(A, [0, 0]), B: episodes(B, [1, 2])}
    for claim in (number("ratio", (B, A), 2.0), Order("order", ((B, A),))):
        found = claim.judge(results)
        assert (found.ours, found.low, found.high, found.p) == (None,) * 4
        assert not found.reproduced


LITTLE, MORE = 5e-10, 2e-9  # less than the round-off of 1e-9 that a band forgives, and more


@pytest.mark.parametrize(
    ("value", "interval", "inside"),
    [
        (1.0 - LITTLE, None, True), (1.0 - MORE, None, False),
        (2.0 + LITTLE, None, True), (2.0 + MORE, None, False),
        (1.5, (0.0, 3.0), True), (0.9, (0.0, 3.0), False), (2.1, (0.0, 3.0), False),
        # a skewed interval need not hold its value
        (1.5, (2.0 + LITTLE, 3.0), True), (1.5, (2.0 + MORE, 3.0), False),
        (1.5, (0.0, 1.0 - LITTLE), True), (1.5, (0.0, 1.0 - MORE), False),
    ],
)  # fmt: skip
def test_a_value_is_in_its_band_if_it_and_its_interval_touch_it(value, interval, inside):
    assert within(Estimate(value, interval, 9), 1.0, 2.0) == inside


@pytest.mark.parametrize(
    ("estimate", "expected"),
    [
        (Estimate(2.0, (1.0, 4.0), 9), ClaimResult("text", "> 1", 2.0, 1.0, 4.0, True, 0.004)),
        (Estimate(2.0, None, 1), ClaimResult("text", "> 1", 2.0, None, None, True, 0.004)),
        (None, ClaimResult("text", "> 1", None, None, None, False)),  # nothing can be said
    ],
)
def test_a_result_holds_the_estimate_its_interval_and_p(estimate, expected):
    claim = Claim()
    claim.text, claim._verdict = "text", lambda _: ("> 1", estimate, True, 0.004)
    assert claim.judge({}) == expected


def test_a_ratio_is_of_the_metric_that_is_asked_for(episodes):
    results = {
        A: episodes(A, [1], on_path_share=0.25), B: episodes(B, [1], on_path_share=0.75)
    }  # fmt: skip
    assert number("path", (B, A), 3.0, metric=on_path).judge(results).ours == 3.0
    assert number("path", A, 0.25, metric=on_path).judge(results).reproduced
    assert Order("path", ((B, A),), on_path).judge(results).ours == 3.0
    assert NoDifference("path", B, A, on_path).judge(results).ours == 3.0
    assert share("trips", (A,), (1.0, 1.0), round_trips).judge(results).ours == 1.0


@pytest.mark.parametrize(
    ("shares", "farthest"),
    [((0.1, 0.8), 0.1), ((0.5, 0.95), 0.95), ((0.35, 0.8), 0.35), ((0.45, 0.7), 0.45)],
)
def test_the_share_farthest_from_the_middle_of_the_range_is_shown(episodes, shares, farthest):
    results = {
        each: episodes(each, [1, 1], on_path_share=level)
        for each, level in zip((A, B), shares, strict=True)
    }
    assert share("path", (A, B), (0.5, 0.7)).judge(results).ours == pytest.approx(farthest)


@pytest.mark.parametrize(("p", "same"), [(None, False), (0.049, False), (0.05, True), (0.9, True)])
def test_two_samples_differ_from_a_p_of_one_in_twenty_down(monkeypatch, episodes, p, same):
    found = Comparison(Estimate(1.0, None, 2), Estimate(2.0, None, 2), p)
    monkeypatch.setattr(claim_types, "compare", lambda one, other: found)
    results = {each: episodes(each, [1, 2]) for each in (A, B)}
    judged = NoDifference("same", A, B).judge(results)
    assert (judged.reproduced, judged.p, judged.ours) == (same, p, 2.0)


def test_an_order_shows_the_least_ratio_and_the_largest_p(episodes):
    results = {A: episodes(A, LOW), B: episodes(B, HIGH), C: episodes(C, range(14, 20))}
    each = [Order("", ((one, A),)).judge(results) for one in (B, C)]
    both = Order("", ((B, A), (C, A))).judge(results)
    assert each[0].p < each[1].p == both.p
    assert each[0].ours > both.ours == pytest.approx(99 / 75)


def test_a_contrast_shows_its_ratio_and_p():
    assert Contrast("slopes", (), lambda _: (HIGH, LOW)).judge({}).reproduced
    assert not Contrast("slopes", (), lambda _: (LOW, HIGH)).judge({}).reproduced
    found = Contrast("slopes", (A, B), lambda _: ([30.0, 32.0, 34.0], [10.0, 11.0, 12.0])).judge({})
    assert (found.ours, found.p, found.reproduced) == (pytest.approx(96 / 33), 0.1, False)


SWEEP = BetaSweep("es1")
SGIKF = Experiment("es1", "ssgikf")


@pytest.fixture
def results(episodes):
    """Every beta gives about 50 round trips, these give others; SGIKF gives about 100."""

    def make(**others):
        levels = dict.fromkeys(SWEEP.experiments, 50) | {SGIKF: 100}
        levels |= {SWEEP.at(float(beta)): level for beta, level in others.items()}
        return {
            experiment: episodes(experiment, [level + step for step in range(-4, 5)])
            for experiment, level in levels.items()
        }

    return make


def test_the_best_beta_is_found_with_its_interval(results):
    for beta, reproduced in ((0.01, True), (0.001, False)):
        found = BestBeta("best", SWEEP, 1e-2).judge(results(**{f"{beta}": 120}))
        assert (found.ours, found.low, found.high) == (beta,) * 3
        assert found.reproduced == reproduced


def test_the_betas_are_those_of_one_filter_in_one_scenario():
    decades = [1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1.0, 10.0, 100.0]
    assert list(BETAS) == pytest.approx(decades)
    assert SWEEP.at(0.001) == Experiment("es1", "ssgiff:beta=0.001")
    assert BetaSweep("es2", "dsgiff").at(10.0) == Experiment("es2", "dsgiff:beta=10")
    names = ["1e-05", "0.0001", "0.001", "0.01", "0.1", "1", "10", "100"]
    assert [each.controller for each in SWEEP.experiments] == [f"ssgiff:beta={n}" for n in names]
    assert SWEEP.best.experiments == SWEEP.experiments


@pytest.mark.parametrize(
    ("n_seeds", "n_good", "n_draws", "is_in"),
    [
        # Of n seeds, the other beta wins in k: it is the best one where at least m of the n that
        # are drawn are among these. The chance of that is a binomial one, worked by hand.
        (10, 2, 5, True),  # 3.3 %, more than the 2.5 % that an interval leaves out on a side
        (10, 1, 3, True),  # 7.0 %
        (6, 2, 5, False),  # 1.8 %
        (10, 1, 4, False),  # 1.3 %
    ],
)
@pytest.mark.parametrize("other", [1e-4, 1.0])
def test_the_interval_leaves_out_what_is_best_in_less_than_a_fortieth_of_the_draws(
    episodes, n_seeds, n_good, n_draws, is_in, other
):
    good = int(100 * n_seeds / (n_draws - 0.5))
    trips = {experiment: [0] * n_seeds for experiment in SWEEP.experiments}
    trips[SWEEP.at(1e-2)] = [100] * n_seeds
    trips[SWEEP.at(other)] = [good] * n_good + [0] * (n_seeds - n_good)
    results = {experiment: episodes(experiment, each) for experiment, each in trips.items()}
    found = SWEEP.optimum(results)
    assert found.value == 1e-2
    assert found.n == n_seeds
    ends = sorted((other, 1e-2)) if is_in else [1e-2, 1e-2]
    assert found.interval == pytest.approx(ends)


def test_an_optimum_may_be_next_to_the_edge(results):
    for beta, inside in (("1e-05", False), ("0.0001", True), ("10", True), ("100", False)):
        found = OptimumInsideRange("inside", SWEEP).judge(results(**{beta: 120}))
        assert (found.reproduced, found.ours) == (inside, pytest.approx(float(beta)))


def test_of_the_other_betas_the_one_nearest_to_the_reference_is_shown(results):
    claim = OtherBetasBelow("below", SWEEP, SGIKF)
    found = claim.judge(results(**{"0.01": 120, "0.1": 80, "1": 20}))
    assert (found.reproduced, found.ours) == (True, pytest.approx(0.8))
    near = claim.judge(results(**{"0.01": 120, "0.1": 98}))
    assert not near.reproduced
    assert near.p > found.p
