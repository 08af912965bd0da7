"""Claims decided by a group sequential test, on samples worked by hand."""

import json
import math

import numpy as np
import pytest
from scipy import stats

from baselines.evaluation.statistics import fieller_interval
from baselines.papers import report
from baselines.papers.beta_sweep import BETAS, BestBeta, BetaSweep, OptimumInsideRange
from baselines.papers.claim_types import (
    Effect,
    NoDifference,
    Order,
    below,
    mean_effect,
    number,
    order_effect,
    share,
)
from baselines.papers.experiments import Experiment, round_trips
from baselines.papers.sequential import LOOKS, decide, decide_all, decision_of

A, B = Experiment("es1", "nc"), Experiment("es1", "ssgikf")


def test_at_the_ends_of_a_ratio_s_interval_the_t_test_of_its_pairs_is_at_its_level():
    x, b = np.array([3.0, 5.0, 4.0, 8.0, 6.0]), np.array([2.0, 3.0, 2.5, 4.0, 5.0])
    low, high = fieller_interval(x, b, 0.9)
    assert low < x.mean() / b.mean() < high
    for end in (low, high):
        assert stats.ttest_1samp(x - end * b, 0.0).pvalue == pytest.approx(0.1)


def test_a_ratio_to_a_mean_that_may_be_zero_has_no_interval():
    assert fieller_interval([1.0, 2.0], [-1.0, 1.1], 0.95) == (-math.inf, math.inf)
    assert fieller_interval([1.0], [1.0], 0.95) == (-math.inf, math.inf)


ONES = [1.0, 1.0]


@pytest.mark.parametrize(
    ("effect", "ends", "wanted"),
    [
        (order_effect(ONES, ONES), (1.001, 1.5), "holds"),
        (order_effect(ONES, ONES), (0.9, 0.999), "fails"),
        (order_effect(ONES, ONES), (0.98, 1.02), "equivalent"),
        (order_effect(ONES, ONES), (0.98, 1.04), "undecided"),
        (mean_effect(ONES, 80.0, 120.0), (81.0, 119.0), "holds"),
        (mean_effect(ONES, 80.0, 120.0), (79.0, 119.0), "undecided"),
        (mean_effect(ONES, 80.0, 120.0), (121.0, 130.0), "fails"),
        (mean_effect(ONES, -math.inf, 50.0), (51.0, 60.0), "fails"),
        (Effect(ONES, ONES, 0.97, 1.03), (0.98, 1.02), "holds"),
        (Effect(ONES, ONES, 0.97, 1.03), (1.01, 1.04), "undecided"),
    ],
)
def test_an_interval_decides_an_effect(effect, ends, wanted):
    assert decision_of(effect, *ends) == wanted


def test_every_claim_says_its_effects(episodes):
    results = {A: episodes(A, [50, 60], on_path_share=0.6), B: episodes(B, [100, 120])}
    ones = [1.0, 1.0]
    for claim, effect in (
        (number("", A, 60.0, 0.1), Effect([50.0, 60.0], ones, 54.0, 66.0)),
        (below("", A, 50.0), Effect([50.0, 60.0], ones, -math.inf, 50.0)),
        (share("", (A,), (0.5, 0.7)), Effect([0.6, 0.6], ones, 0.4, 0.8)),
        (number("", (B, A), 2.0, 0.5), Effect([100.0, 120.0], [50.0, 60.0], 1.0, 3.0)),
        (NoDifference("", A, B), Effect([50.0, 60.0], [100.0, 120.0], 0.97, 1.03)),
        (Order("", ((B, A),)), Effect([100.0, 120.0], [50.0, 60.0], 1.0, math.inf)),
    ):
        (found,) = claim.effects(results)
        assert (found.values, found.base) == (effect.values, effect.base)
        assert (found.low, found.high) == pytest.approx((effect.low, effect.high))


def test_a_claim_of_the_best_beta_is_one_of_all_others(episodes):
    sweep = BetaSweep("es1")
    trips = [100, 110, 120, 130, 120, 110, 100, 90]
    results = {
        each: episodes(each, [n, n])
        for each, n in zip(sweep.experiments, trips, strict=True)
    }  # fmt: skip
    for index, wanted in ((3, "holds"), (2, "fails")):
        assert decide(BestBeta("", sweep, BETAS[index]), results, 2).decision == wanted
    inside = OptimumInsideRange("", sweep)
    assert len(inside.effects(results)) == 2
    assert decide(inside, results, 2).decision == "holds"
    results[sweep.experiments[-1]] = episodes(A, [140, 140])
    found = decide(inside, results, 2)
    assert (found.decision, found.ours) == ("fails", pytest.approx(130 / 140))


def test_the_level_is_shared_by_looks_and_effects(episodes):
    trips = [3, 5, 4, 8]
    results = {A: episodes(A, trips)}
    two = share("", (A, A), (0.0, 1.0), round_trips)
    found = decide(two, results, 4)
    wanted = fieller_interval(trips, [1.0] * 4, 1.0 - 0.05 / (5 * 2))
    assert (found.low, found.high) == wanted
    error = np.std(trips, ddof=1) / math.sqrt(30) / np.mean(trips)
    assert found.resolved == pytest.approx(1.959964 * error)


def test_values_that_are_all_one_number_decide_no_claim_but_of_a_share_by_the_exact_interval(
    episodes,
):
    same = {each: episodes(each, [100] * 60) for each in (A, B)}
    for claim in (NoDifference("", A, B), Order("", ((B, A),))):
        assert decide(claim, same, 30).decision == "undecided"
    late = share("", (A,), (1.0, 1.0), lambda _: 1.0)
    for n, decision in ((30, "undecided"), (60, "holds")):
        found = decide(late, {A: same[A][:n]}, n)
        assert (found.decision, found.low) == (decision, pytest.approx(0.005 ** (1 / n)))
    assert math.isnan(found.resolved)


def test_episodes_are_added_to_open_claims_alone_until_all_are_decided(episodes):
    generator = np.random.default_rng(1)
    noise = generator.normal(0.0, 20.0, LOOKS[-1])
    asked = []

    def run(experiments, n):
        asked.append((experiments, n))
        near = {A: episodes(A, 100.0 + noise[:n]), B: episodes(B, 106.0 + np.roll(noise, 1)[:n])}
        return {each: near[each] for each in experiments}

    clear, close = number("clear", A, 100.0), Order("close", ((B, A),))
    tie = NoDifference("tie", A, B)
    looks = list(decide_all([clear, close, tie], run))
    assert [each.decision for each in looks[0]] == ["holds", "undecided", "undecided"]
    assert len(looks) == len(LOOKS)
    found = looks[-1]
    assert [(each.claim, each.decision, each.n) for each in found] == [
        ("clear", "holds", 30), ("close", "holds", 120), ("tie", "undecided", 400),
    ]  # fmt: skip
    assert asked[0] == ((A, B), 30)
    assert [n for _, n in asked] == list(LOOKS)
    assert json.loads(report.decisions_json(found))[0]["decision"] == "holds"
    assert report.count(found) == "Of 3 claims 2 hold, 0 are equivalent, 1 is undecided, 0 fail"
    assert "| close | > 1 | " in report._decided(found)
