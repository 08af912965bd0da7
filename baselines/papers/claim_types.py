"""Types of claims: a number, a bound, a share, a ratio, an order, no difference.

Reproduced is a number within 20 % (15 % for es1) of the published one whose 95 % interval touches
that band, a share within 10 points, and an order with a Mann-Whitney p below 0.01.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from baselines.evaluation.statistics import Comparison, Estimate, compare, mean_interval
from baselines.papers.experiments import (
    Experiment,
    Metric,
    Pool,
    Results,
    Source,
    UsesFields,
    on_path,
    round_trips,
    sample,
)

SIGNIFICANT = 0.01
"""An order holds if its Mann-Whitney p is below this."""

ROUND_OFF = 1e-9
"""Tolerance at the ends of a range, so that a value on an end is inside."""

INDISTINCT = 0.05
"""Two samples do not differ significantly if their Mann-Whitney p is at least this."""

POINTS = 0.10
"""Largest deviation of a share from the published one."""

MARGIN = 0.03
"""Two means are equivalent if their ratio lies within 1 - MARGIN and 1 + MARGIN."""


def shown(value: float) -> str:
    """Format a value of a claim for a table."""
    return f"{value:.0f}" if abs(value) >= 100.0 else f"{value:.3g}"


@dataclass(frozen=True)
class ClaimResult:
    """Result of one claim: a row of the claims table."""

    claim: str
    published: float | str
    """Number in the paper, or the range or order that it states."""
    ours: float | None
    """Measured value; None if it is undefined: a ratio to zero."""
    low: float | None
    """Lower end of the 95 % interval; both ends are None for equal values or a single one."""
    high: float | None
    reproduced: bool
    p: float | None = None
    """Mann-Whitney p of a comparison; the largest of several."""


@dataclass(frozen=True)
class Effect:
    """Statement that one mean, or the ratio of two means, lies from `low` to `high`."""

    values: Sequence[float]
    """A value for each seed."""
    base: Sequence[float]
    """Values of the other side; ones for a mean."""
    low: float
    high: float
    is_mean: bool = False

    @property
    def estimate(self) -> Estimate | None:
        """Mean, or ratio of the means; None without values, and for a ratio to zero."""
        return mean_interval(self.values) if self.is_mean else compare(self.values, self.base).ratio

    @property
    def range(self) -> str:
        """Range in words: `> 1`."""
        if math.isinf(self.high):
            return f"> {self.low:g}"
        return f"< {self.high:g}" if math.isinf(self.low) else f"{self.low:g} to {self.high:g}"


def mean_effect(values: Sequence[float], low: float, high: float) -> Effect:
    """Return the effect that a mean lies in a range."""
    return Effect(values, [1.0] * len(values), low, high, is_mean=True)


def order_effect(higher: Sequence[float], lower: Sequence[float]) -> Effect:
    """Return the effect that one mean lies above another."""
    return Effect(higher, lower, 1.0, math.inf)


Verdict = tuple[float | str, Estimate | None, bool, float | None]
"""Published value, our estimate, whether it is reproduced, and the p of a comparison."""


class Claim(UsesFields):
    """Base of the claims: a statement of a paper, `text`, that can be measured here."""

    text: str

    def judge(self, results: Results) -> ClaimResult:
        """Judge the claim by these results."""
        published, ours, reproduced, p = self._verdict(results)
        if ours is None:
            return ClaimResult(self.text, published, None, None, None, reproduced=False)
        low, high = ours.interval or (None, None)
        return ClaimResult(self.text, published, ours.value, low, high, reproduced, p)

    def _verdict(self, results: Results) -> Verdict:
        raise NotImplementedError


class DecidableClaim(Claim):
    """Base of the claims that more episodes can decide (`baselines.papers.sequential`)."""

    def effects(self, results: Results) -> Sequence[Effect]:
        """Return the effects of the claim, all of which must lie in their ranges."""
        raise NotImplementedError


def within(ours: Estimate, low: float, high: float) -> bool:
    """Return whether the value lies in the band, and its interval touches the band."""
    start, end = ours.ends
    inside = low - ROUND_OFF <= ours.value <= high + ROUND_OFF
    return inside and start <= high + ROUND_OFF and end >= low - ROUND_OFF


def above(comparison: Comparison) -> bool:
    """Return whether the first sample of a comparison lies above the second one, with p < 0.01."""
    p = comparison.p
    return comparison.difference.value > 0.0 and p is not None and p < SIGNIFICANT


Quantity = Source | Pool | tuple[Source | Pool, Source | Pool]
"""Source of a mean, or two sources of a ratio of means."""


@dataclass(frozen=True)
class InRange(DecidableClaim):
    """Claim: each mean, or ratio of two, is in a range; the farthest from its middle is shown."""

    text: str
    sources: tuple[Quantity, ...]
    published: float | str
    low: float
    high: float
    metric: Metric = round_trips

    def _verdict(self, results: Results) -> Verdict:
        middle = (self.low + self.high) / 2.0
        ours = [known for each in self.effects(results) if (known := each.estimate)]
        worst = max(ours, key=lambda each: abs(each.value - middle), default=None)
        inside = worst is not None and within(worst, self.low, self.high)
        return self.published, worst, inside, None

    def effects(self, results: Results) -> list[Effect]:
        """Return the effects: each mean, or ratio of two, lies in the range."""
        ends = self.low, self.high
        return [
            Effect(*both(results, *each, self.metric), *ends)
            if isinstance(each, tuple)
            else mean_effect(sample(results, each, self.metric), *ends)
            for each in self.sources
        ]


def number(
    text: str,
    source: Quantity,
    published: float,
    tolerance: float = 0.20,
    metric: Metric = round_trips,
) -> InRange:
    """Return the claim that a mean, or the ratio of two, is near a published number."""
    margin = tolerance * published
    return InRange(text, (source,), published, published - margin, published + margin, metric)


def below(text: str, source: Source, bound: float) -> InRange:
    """Return the claim that the mean of the round trips is less than a published bound."""
    return InRange(text, (source,), f"< {bound:g}", -math.inf, bound)


def share(
    text: str,
    sources: tuple[Source | Pool, ...],
    published: tuple[float, float],
    metric: Metric = on_path,
) -> InRange:
    """Return the claim that every share lies in a published range, extended by 10 points."""
    low, high = published
    published_range = low if low == high else f"{low:g} to {high:g}"
    return InRange(text, sources, published_range, low - POINTS, high + POINTS, metric)


class Above(DecidableClaim):
    """Base of the claims that samples lie above others; the least ratio is shown."""

    def _verdict(self, results: Results) -> Verdict:
        effects = self.effects(results)
        if not all(each.values for each in effects):
            return "> 1", None, False, None
        comparisons = [compare(each.values, each.base) for each in effects]
        ratios = [each.ratio for each in comparisons if each.ratio is not None]
        least = min(ratios, key=lambda ratio: ratio.value, default=None)
        largest = max((each.p for each in comparisons if each.p is not None), default=None)
        return "> 1", least, all(map(above, comparisons)), largest


@dataclass(frozen=True)
class Order(Above):
    """Claim: in every pair, one sample lies above the other."""

    text: str
    pairs: tuple[tuple[Source, Source], ...]
    """Pairs of the higher and the lower source."""
    metric: Metric = round_trips

    def effects(self, results: Results) -> list[Effect]:
        """Return the effects: in every pair, one mean lies above the other."""
        sides = (present_pairs(results, *each, self.metric) for each in self.pairs)
        return [order_effect(*each) for each in sides]


@dataclass(frozen=True)
class Contrast(Above):
    """Claim: a value of each seed, such as a slope, is larger in one condition than in another."""

    text: str
    sources: tuple[Experiment, ...]
    contrast: Callable[[Results], tuple[list[float], list[float]]]
    """Returns the larger and the smaller values, one for each seed."""

    def effects(self, results: Results) -> list[Effect]:
        """Return the effect: the mean of the larger values lies above the other."""
        return [order_effect(*self.contrast(results))]


@dataclass(frozen=True)
class NoDifference(DecidableClaim):
    """Claim: two samples do not differ (Mann-Whitney p >= 0.05); their ratio is shown.

    The claim fails if all values are equal, as in episodes too short for a recruitment.
    """

    text: str
    one: Source
    other: Source
    metric: Metric = round_trips

    def _verdict(self, results: Results) -> Verdict:
        comparison = compare(*both(results, self.one, self.other, self.metric))
        same = comparison.p is not None and comparison.p >= INDISTINCT
        return 1.0, comparison.ratio, same, comparison.p

    def effects(self, results: Results) -> list[Effect]:
        """Return the effect: the two means are equivalent."""
        sides = both(results, self.one, self.other, self.metric)
        return [Effect(*sides, 1.0 - MARGIN, 1.0 + MARGIN)]


def both(
    results: Results, one: Source | Pool, other: Source | Pool, metric: Metric
) -> tuple[list[float], list[float]]:
    """Return the metric of both sources for each seed."""
    return sample(results, one, metric), sample(results, other, metric)


def present_pairs(
    results: Results, one: Source, other: Source, metric: Metric
) -> tuple[list[float], list[float]]:
    """Return the metric of both sources for each seed for which both have one."""
    pairs = zip(*both(results, one, other, metric), strict=True)
    finite = [(a, b) for a, b in pairs if not (math.isnan(a) or math.isnan(b))]
    return [a for a, _ in finite], [b for _, b in finite]
