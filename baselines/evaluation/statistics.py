"""Statistics: means with intervals, comparisons of two controllers, runs of learners.

A result is None if it is undefined: an interval of one value or of equal values, a ratio to zero.
"""

import math
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy import stats

from swarm_forage_env.arrays import Array, Float64

Values = Float64[Array, "..."]

CONFIDENCE = 0.95  # of all intervals
RESAMPLES = 9999  # drawn for an interval
RUN_RESAMPLES = 2000  # of the runs of learners, drawn for an interval
BATCH = 1_000_000  # values of resamples held in memory at a time

FEW = 10
"""Values from which an interval is a bootstrap. Of normal ones that holds the mean in 50 % of the
samples of two, 86 % of six, 89 % of ten, 94 % of 30; of fewer it is Student's, and of a ratio
Fieller's, which hold it in 95 %."""

INTERVALS = f"95 % intervals (BCa bootstrap; of fewer than {FEW} values Student's)"
"""What a caption says of them."""


@dataclass(frozen=True)
class Estimate:
    """A mean or ratio with its confidence interval."""

    value: float
    interval: tuple[float, float] | None
    n: int
    """Number of values from which it was estimated."""

    @property
    def ends(self) -> tuple[float, float]:
        """The interval; the value itself at both ends where there is none."""
        return self.interval or (self.value, self.value)


@dataclass(frozen=True)
class Comparison:
    """The comparison of one controller with another one on the same seeds."""

    difference: Estimate
    """Mean of the differences, seed by seed."""
    ratio: Estimate | None
    """Ratio of the means."""
    p: float | None
    """Two-sided p of the Mann-Whitney U test."""


def mean_interval(values: Sequence[float], seed: int = 0) -> Estimate | None:
    """The mean and its 95 % interval, of resamples drawn with `seed`; None without values.

    Source: EfronTibshirani1993, ch. 14 (bias-corrected and accelerated, BCa).

    >>> mean_interval([4.0])
    Estimate(value=4.0, interval=None, n=1)
    >>> mean_interval([4.0, 6.0]).interval  # 5 -+ 12.706 x 1
    (-7.706..., 17.706...)
    """
    if not values:
        return None
    sample = np.asarray(values, dtype=np.float64)
    return Estimate(float(sample.mean()), _interval((sample,), np.mean, seed), len(sample))


def compare(values: Sequence[float], base: Sequence[float], seed: int = 0) -> Comparison:
    """Compare a sample x with a base sample b of the same seeds in the same order.

    The difference is mean(x_k - b_k), the ratio mean(x) / mean(b).

    >>> compare([5.0, 7.0, 8.0], [4.0, 5.0, 6.0]).difference.value
    1.6666666666666667
    """
    x, b = np.asarray(values, dtype=np.float64), np.asarray(base, dtype=np.float64)
    difference = mean_interval((x - b).tolist(), seed)
    if difference is None:
        raise ValueError("a comparison needs at least one pair")
    ratio = None  # to a base of zero
    if b.mean() != 0.0:
        ratio = Estimate(float(_mean_ratio(x, b)), _interval((x, b), _mean_ratio, seed), len(x))
    return Comparison(difference, ratio, mann_whitney_p(values, base))


def mann_whitney_p(values: Sequence[float], base: Sequence[float]) -> float | None:
    """Two-sided p of the Mann-Whitney U test; None for samples too small or all equal.

    Source: MannWhitney1947.

    >>> round(mann_whitney_p([1.0, 2.0, 3.0], [4.0, 5.0, 6.0]), 6)
    0.1
    """
    if min(len(values), len(base)) < 2 or len({*values, *base}) == 1:
        return None
    return float(stats.mannwhitneyu(values, base, alternative="two-sided").pvalue)


def fieller_interval(
    values: Sequence[float], base: Sequence[float], level: float
) -> tuple[float, float]:
    """The ends of the interval of mean(values) / mean(base), drawn in pairs.

    A ratio r is inside unless mean(values - r base) differs from zero by a t test, so that the ends
    are the roots of (x - r b)^2 = t^2 (S_xx - 2 r S_xb + r^2 S_bb) / n. The ends are infinite where
    the mean of the base does not differ from zero itself.

    Source: Fieller1954.
    """
    n, x, b = len(values), float(np.mean(values)), float(np.mean(base))
    if n < 2:
        return -math.inf, math.inf
    (s_xx, s_xb), (_, s_bb) = np.cov(values, base) / n * stats.t.ppf(0.5 + 0.5 * level, n - 1) ** 2
    square, half, rest = b * b - s_bb, x * b - s_xb, x * x - s_xx
    if square <= 0.0:
        return -math.inf, math.inf
    root = math.sqrt(max(half * half - square * rest, 0.0))
    return (half - root) / square, (half + root) / square


def iqm(values: ArrayLike, axis: int = -1) -> Values:
    """The interquartile mean: of the middle half of the values.

    Source: AgarwalEtAl2021, Section 4.3.

    >>> float(iqm([0.0, 1.0, 2.0, 30.0]))
    1.5
    """
    return np.asarray(stats.trim_mean(values, 0.25, axis=axis))


def iqm_interval(strata: Sequence[Sequence[float]], seed: int = 0) -> Estimate | None:
    """The interquartile mean of all runs and its stratified bootstrap interval.

    A stratum is a task, its values are the scores of the runs; runs are resampled within each task,
    and the interval lies between percentiles. None without values.

    >>> iqm_interval([[1.0, 2.0, 3.0, 30.0]]).value
    2.5

    Source: AgarwalEtAl2021, Section 4.1.
    """
    if not any(map(len, strata)):
        return None
    values, drawn = _resampled(strata, seed)
    varied = any(np.ptp(each) > 0.0 for each in strata if len(each))
    low, high = map(float, middle(iqm(drawn)))
    return Estimate(float(iqm(values)), (low, high) if varied else None, len(values))


def performance_profile(
    strata: Sequence[Sequence[float]], taus: Sequence[float], seed: int = 0
) -> tuple[Values, Values, Values]:
    """The share of runs above each score tau, and the ends of its stratified bootstrap interval.

    Source: AgarwalEtAl2021, Section 4.2; DolanMore2002.

    >>> performance_profile([[0.2, 0.6, 0.9]], [0.5])[0].round(2).tolist()
    [0.67]
    """
    values, drawn = _resampled(strata, seed)
    share = np.array([(values > tau).mean() for tau in taus])
    ends = np.array([middle((drawn > tau).mean(axis=-1)) for tau in taus])
    return share, ends[:, 0], ends[:, 1]


def probability_of_improvement(
    strata: Sequence[Sequence[float]], base: Sequence[Sequence[float]], seed: int = 0
) -> Estimate:
    """The probability that a run scores above one of a base on the same task, a mean over tasks.

    A tie counts half. The interval resamples the runs of either side within each task.

    Source: AgarwalEtAl2021, Section 4.3.

    >>> probability_of_improvement([[1.0, 3.0]], [[2.0, 1.0]]).value
    0.625
    """
    generator = np.random.default_rng(seed)
    values, draws = [], []
    for own, other in zip(strata, base, strict=True):
        sides = [np.asarray(each, np.float64) for each in (own, other)]
        x, b = (generator.choice(each, (RUN_RESAMPLES, len(each))) for each in sides)
        values.append(_wins(*(each[None] for each in sides))[0])
        draws.append(_wins(x, b))
    low, high = map(float, middle(np.mean(draws, axis=0)))
    n = sum(map(len, strata))
    return Estimate(float(np.mean(values)), (low, high) if low < high else None, n)


def _wins(x: Values, b: Values) -> Values:
    """For each row, the share of pairs in which x is above b; ties count half."""
    gaps = x[:, :, None] - b[:, None, :]
    return np.asarray((0.5 + 0.5 * np.sign(gaps)).mean(axis=(1, 2)))


def _resampled(
    strata: Sequence[Sequence[float]], seed: int
) -> tuple[Float64[Array, " runs"], Float64[Array, "draws runs"]]:
    """All runs, and resamples of them, drawn within each stratum; ValueError without runs."""
    generator = np.random.default_rng(seed)
    runs = [np.asarray(each, np.float64) for each in strata if len(each)]
    parts = [generator.choice(each, (RUN_RESAMPLES, len(each))) for each in runs]
    return np.concatenate(runs), np.concatenate(parts, axis=1)


def middle(values: Values, method: Literal["linear", "nearest"] = "linear") -> Values:
    """The ends between which 95 % of the values lie, along their first axis."""
    tail = 50.0 * (1.0 - CONFIDENCE)
    return np.asarray(np.percentile(values, [tail, 100.0 - tail], axis=0, method=method))


def _mean_ratio(x: Values, b: Values, axis: int = -1) -> Values:
    return np.asarray(np.mean(x, axis=axis) / np.mean(b, axis=axis))


def _interval(
    samples: tuple[Values, ...], statistic: Callable[..., Values], seed: int
) -> tuple[float, float] | None:
    """Bootstrap interval, resampling the samples together; None if all are constant or not finite.

    For fewer values than FEW it is Fieller's, which for a mean (a ratio to ones) is Student's.
    """
    if not any(np.ptp(each) > 0.0 for each in samples):
        return None
    if len(samples[0]) < FEW:
        values, base, *_ = *samples, np.ones_like(samples[0])
        ends = fieller_interval(values.tolist(), base.tolist(), CONFIDENCE)
    else:
        with np.errstate(all="ignore"), warnings.catch_warnings():  # a resample may be all zero
            warnings.simplefilter("ignore", stats.DegenerateDataWarning)  # tested for below
            ends = stats.bootstrap(
                samples,
                statistic,
                n_resamples=RESAMPLES,
                batch=max(1, BATCH // len(samples[0])),
                paired=len(samples) > 1,
                vectorized=True,
                confidence_level=CONFIDENCE,
                method="BCa",
                rng=np.random.default_rng(seed),
            ).confidence_interval
    low, high = map(float, ends)
    return (low, high) if math.isfinite(low) and math.isfinite(high) else None
