"""Intervals and comparisons against closed forms and cases worked by hand."""

import math

import numpy as np
import pytest
from scipy import stats

from baselines.evaluation.line_plots import mean_curve
from baselines.evaluation.statistics import (
    compare,
    iqm,
    iqm_interval,
    mann_whitney_p,
    mean_interval,
    performance_profile,
    probability_of_improvement,
)


def test_the_interval_is_that_of_normal_theory_for_many_normal_values():
    values = np.random.default_rng(0).normal(10.0, 2.0, 400)
    found = mean_interval(values.tolist())
    half = 1.96 * values.std(ddof=1) / math.sqrt(len(values))
    low, high = found.interval
    assert found.value == pytest.approx(values.mean())
    assert low == pytest.approx(values.mean() - half, abs=0.05 * half)
    assert high == pytest.approx(values.mean() + half, abs=0.05 * half)


def test_the_interval_of_skewed_values_is_corrected_for_bias_and_acceleration():
    values = np.random.default_rng(3).lognormal(0.0, 1.2, 15)

    def of(method):
        random = np.random.default_rng(8)
        found = stats.bootstrap((values,), np.mean, n_resamples=9999, method=method, rng=random)
        return np.array(found.confidence_interval)

    bca, percentile = of("BCa"), of("percentile")
    assert np.abs(bca - percentile).max() > 0.2
    assert mean_interval(values.tolist()).interval == pytest.approx(tuple(bca), rel=0.05)


def test_the_interval_of_nine_values_is_student_s_as_is_the_band_of_a_curve():
    values = np.random.default_rng(3).lognormal(0.0, 1.2, 9)
    wanted = stats.t.interval(0.95, 8, values.mean(), stats.sem(values))
    assert mean_interval(values.tolist()).interval == pytest.approx(wanted)
    band = mean_curve(np.zeros(1), values[:, None])
    assert (band.low[0], band.high[0]) == pytest.approx(wanted)
    assert np.isnan(mean_curve(np.zeros(1), values[:1, None]).low)


VALUES = np.random.default_rng(0).normal(0.0, 1.0, 20).tolist()


@pytest.mark.parametrize(
    ("interval", "values"), [(mean_interval, VALUES), (iqm_interval, [VALUES])]
)
def test_one_seed_one_interval(interval, values):
    assert interval(values, seed=3) == interval(values, seed=3)
    assert interval(values, seed=3) != interval(values, seed=4)


@pytest.mark.parametrize("values", [[7.0], [7.0, 7.0, 7.0], [0.0] * 30])
def test_one_value_and_equal_values_have_a_mean_and_no_interval(values):
    found = mean_interval(values)
    assert (found.value, found.interval, found.n) == (values[0], None, len(values))
    assert mean_interval([]) is None


@pytest.mark.parametrize(
    ("values", "base", "p"),
    [
        ([1, 3], [2, 4], 4 / 6),  # U = 1; of the 6 ways 4 have U <= 1 or U >= 3
        ([1], [2], None), ([], [1, 2], None), ([5, 5], [5, 5], None),
    ],
)  # fmt: skip
def test_mann_whitney_by_hand_which_says_nothing_of_single_or_equal_values(values, base, p):
    assert mann_whitney_p(values, base) == pytest.approx(p)


def test_a_comparison_pairs_the_seeds():
    base = [10.0, 200.0, 3000.0]
    found = compare([base_k + 1.0 + 0.1 * k for k, base_k in enumerate(base)], base)
    assert found.difference.value == pytest.approx(1.1)
    low, high = found.difference.interval
    assert 0.8 <= low < 1.1 < high <= 1.4, "the spread between seeds cancels"


def test_the_interval_of_a_ratio_holds_it():
    rng = np.random.default_rng(2)
    base = rng.normal(100.0, 10.0, 30)
    found = compare((base * rng.normal(2.0, 0.1, 30)).tolist(), base.tolist())
    low, high = found.ratio.interval
    assert low < 2.0 < high
    assert high - low < 0.15


def test_a_base_of_zeros_has_no_ratio_and_one_that_may_be_resampled_to_it_no_interval():
    found = compare([1.0, 2.0, 3.0], [0.0, 0.0, 0.0])
    assert (found.ratio, found.difference.value) == (None, 2.0)
    found = compare([1.0, 2.0, 3.0], [0.0, 0.0, 3.0])
    assert found.ratio.value == pytest.approx(2.0)
    assert found.ratio.interval is None


def test_the_interquartile_mean_leaves_out_a_quarter_at_either_end():
    assert iqm([-1e9, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 1e9]) == pytest.approx(3.5)
    assert iqm(np.array([[1.0, 1.0, 1.0, 9.0], [0.0, 2.0, 4.0, 8.0]])).tolist() == [1.0, 3.0]


def test_runs_are_resampled_within_their_task():
    assert iqm_interval([]) is None
    apart = iqm_interval([[0.0] * 4, [1.0] * 4])
    assert (apart.value, apart.interval, apart.n) == (0.5, None, 8)
    mixed = iqm_interval([[0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 1.0]])
    assert mixed.value == 0.5
    assert mixed.interval[0] < 0.2 < 0.8 < mixed.interval[1]
    one_varies = iqm_interval([[0.0] * 4, [1.0, 1.2, 1.4, 1.6]])
    assert one_varies.interval[1] - one_varies.interval[0] < 0.3


def test_a_profile_is_the_share_of_runs_above_each_score():
    share, low, high = performance_profile([[0.1, 0.5], [0.5, 0.9]], [0.0, 0.1, 0.5, 0.9])
    assert share.tolist() == [1.0, 0.75, 0.25, 0.0]
    assert np.all((low <= share) & (share <= high))
    assert (low[0], high[0], low[-1], high[-1]) == (1.0, 1.0, 0.0, 0.0)
    with pytest.raises(ValueError, match="at least one"):
        performance_profile([], [0.5])


def test_the_interval_of_a_profile_is_that_of_a_share_drawn_within_each_task():
    runs = np.linspace(0.0, 1.0, 100).tolist()
    _, (low,), (high,) = performance_profile([runs], [0.5])
    found = stats.binom(100, 0.5).ppf([0.025, 0.975]) / 100
    assert [low, high] == pytest.approx(found, abs=0.015)
    _, (low,), (high,) = performance_profile([[0.0] * 50, [1.0] * 50], [0.5])
    assert (low, high) == (0.5, 0.5), "as many of each task as there are"


@pytest.mark.parametrize(
    ("values", "base"), [([0.5, 0.75, 0.5, 0.7], [1.0] * 4), ([1.0] * 4, [0.5, 0.75, 0.5, 0.7])]
)
def test_a_ratio_has_an_interval_though_its_samples_vary_by_less_than_one(values, base):
    ratio = compare(values, base).ratio
    low, high = ratio.interval
    assert low < ratio.value < high
    mean = mean_interval(values if len(set(values)) > 1 else base)
    assert mean.interval[0] < mean.value < mean.interval[1]


def test_the_probability_of_improvement_is_a_mean_over_tasks():
    better = [[2.0, 3.0, 4.0], [1.0, 1.0]]
    base = [[1.0, 1.5, 1.0], [1.0, 1.0, 1.0]]
    found = probability_of_improvement(better, base)
    assert (found.value, found.interval, found.n) == (0.75, None, 5)
    low, high = probability_of_improvement([[1.0, 3.0, 2.0]], [[2.0, 1.0, 2.5]]).interval
    assert 0.0 <= low < 0.5 < high <= 1.0
    with pytest.raises(ValueError, match="zip"):
        probability_of_improvement(better, base[:1])
