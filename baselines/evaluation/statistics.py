"""Statistics: means with bootstrap intervals, and comparisons of two controllers.

None stands where the numbers say nothing: an interval of one value or of equal values, a
ratio to zero.
"""

import math
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import stats

CONFIDENCE = 0.95
"""Of all intervals."""

RESAMPLES = 9999
"""Drawn for an interval."""

BATCH = 1000
"""Resamples held in memory at a time."""


@dataclass(frozen=True)
class Estimate:
    """A mean or ratio with its confidence interval."""

    value: float
    interval: tuple[float, float] | None
    n: int
    """Values it was estimated from."""


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
    """The mean and its 95 % bootstrap interval; None without values.

    Source: EfronTibshirani1993, ch. 14 (bias-corrected and accelerated, BCa).

    >>> mean_interval([4.0])
    Estimate(value=4.0, interval=None, n=1)
    """
    if not values:
        return None
    sample = np.asarray(values, dtype=np.float64)
    varied = np.ptp(sample) > 0.0
    return Estimate(
        float(sample.mean()), _interval((sample,), np.mean, seed) if varied else None, len(sample)
    )


def compare(values: Sequence[float], base: Sequence[float], seed: int = 0) -> Comparison:
    """Compare a sample with a base sample of the same seeds in the same order.

    The difference is mean(x_k - b_k), the ratio mean(x) / mean(b).
    """
    x, b = np.asarray(values, dtype=np.float64), np.asarray(base, dtype=np.float64)
    difference = mean_interval([float(d) for d in x - b], seed)
    if difference is None:
        raise ValueError("a comparison needs at least one pair")
    return Comparison(difference, _ratio(x, b, seed), mann_whitney_p(values, base))


def mann_whitney_p(values: Sequence[float], base: Sequence[float]) -> float | None:
    """Two-sided p of the Mann-Whitney U test; None for samples too small or all equal.

    Source: MannWhitney1947.

    >>> round(mann_whitney_p([1.0, 2.0, 3.0], [4.0, 5.0, 6.0]), 6)
    0.1
    """
    if min(len(values), len(base)) < 2 or len({*values, *base}) == 1:
        return None
    return float(stats.mannwhitneyu(values, base, alternative="two-sided").pvalue)


def _ratio(x: Any, b: Any, seed: int) -> Estimate | None:  # noqa: ANN401 arrays of numbers
    """Ratio of the means, its interval resampling whole seeds; None to a base of zero."""
    if b.mean() == 0.0:
        return None
    ratio = float(x.mean() / b.mean())
    varied = np.ptp(x) > 0.0 or np.ptp(b) > 0.0
    return Estimate(ratio, _interval((x, b), _mean_ratio, seed) if varied else None, len(x))


def _mean_ratio(x: Any, b: Any, axis: int = -1) -> Any:  # noqa: ANN401 arrays of numbers
    with np.errstate(divide="ignore", invalid="ignore"):  # a resample of b may be all zero
        return np.mean(x, axis=axis) / np.mean(b, axis=axis)


def _interval(
    samples: tuple[Any, ...], statistic: Callable[..., Any], seed: int
) -> tuple[float, float] | None:
    """Bootstrap interval, resampling the samples together; None where it is not finite."""
    if len(samples[0]) < 2:
        return None
    with np.errstate(all="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore", stats.DegenerateDataWarning)  # tested for below
        found = stats.bootstrap(
            samples,
            statistic,
            n_resamples=RESAMPLES,
            batch=BATCH,
            paired=len(samples) > 1,
            vectorized=True,
            confidence_level=CONFIDENCE,
            method="BCa",
            rng=np.random.default_rng(seed),
        ).confidence_interval
    low, high = float(found.low), float(found.high)
    return (low, high) if math.isfinite(low) and math.isfinite(high) else None
