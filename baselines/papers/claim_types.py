"""Types of claims: a number, a bound, a share, a ratio, an order, no difference.

Reproduced means: a number within 20 % (15 % for es1) of the published one, its 95 % interval
touching that band; a share within 10 points; an order with a Mann-Whitney p below 0.01.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass

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
"""An ordering holds if its Mann-Whitney p is below this."""

ROUND_OFF = 1e-9
"""A number on the edge of its band is inside."""

INDISTINCT = 0.05
"""Two samples do not differ significantly if their Mann-Whitney p is at least this."""

POINTS = 0.10
"""How far a share may lie from the published one."""

MARGIN = 0.03
"""Two means are equivalent if their ratio lies within 1 - MARGIN and 1 + MARGIN."""


def shown(value: float) -> str:
    """A number of a claim in a table."""
    return f"{value:.0f}" if abs(value) >= 100.0 else f"{value:.3g}"


@dataclass(frozen=True)
class ClaimResult:
    """The result of one claim: a row of the claims table."""

    claim: str
    published: float | str
    """The number of the paper, or the range or order it states."""
    ours: float | None
    """None where nothing can be said: a ratio to zero."""
    low: float | None
    """Ends of the 95 % interval; None where all values are equal, or there is one only."""
    high: float | None
    reproduced: bool
    p: float | None = None
    """Of a comparison: its Mann-Whitney p, the largest one of several."""

    def as_row(self) -> dict[str, object]:
        """The result as a dictionary for JSON."""
        return {name: value for name, value in asdict(self).items() if name != "p"}


def claim_result(
    text: str,
    published: float | str,
    ours: Estimate | None,
    reproduced: bool,
    p: float | None = None,
) -> ClaimResult:
    """Make a claim's result from an estimate with its interval."""
    if ours is None:
        return ClaimResult(text, published, None, None, None, reproduced=False)
    low, high = ours.interval or (None, None)
    return ClaimResult(text, published, ours.value, low, high, reproduced, p)


@dataclass(frozen=True)
class Effect:
    """What a claim says of one mean, or of the ratio of two: that it lies from `low` to `high`."""

    values: Sequence[float]
    """A number for each seed."""
    base: Sequence[float]
    """The same of the other side; ones for a mean."""
    low: float
    high: float

    @property
    def says(self) -> str:
        """The range in words: `> 1`."""
        if math.isinf(self.high):
            return f"> {self.low:g}"
        return f"< {self.high:g}" if math.isinf(self.low) else f"{self.low:g} to {self.high:g}"


def mean_effect(values: Sequence[float], low: float, high: float) -> Effect:
    """What is said of a mean."""
    return Effect(values, [1.0] * len(values), low, high)


def order_effect(higher: Sequence[float], lower: Sequence[float]) -> Effect:
    """That one mean lies above another."""
    return Effect(higher, lower, 1.0, math.inf)


Verdict = tuple[float | str, Estimate | None, bool, float | None]
"""What was published, what is ours, whether it is reproduced, and the p of a comparison."""


class Claim(UsesFields):
    """Base of the claims: a statement of a paper, with its `text`, that can be measured here."""

    text: str

    def judge(self, results: Results) -> ClaimResult:
        """Judge the claim on these results."""
        return claim_result(self.text, *self._verdict(results))

    def _verdict(self, results: Results) -> Verdict:
        raise NotImplementedError


class DecidableClaim(Claim):
    """Base of the claims that more episodes can decide (`baselines.papers.sequential`)."""

    def effects(self, results: Results) -> Sequence[Effect]:
        """The effects of the claim, all of which must lie where it says."""
        raise NotImplementedError


def estimate(values: list[float]) -> Estimate:
    """The mean of a sample with its interval."""
    mean = mean_interval(values)
    if mean is None:
        raise ValueError("a claim needs at least one episode")
    return mean


def within(ours: Estimate, low: float, high: float) -> bool:
    """Whether the value lies in the band, and its interval touches the band."""
    start, end = ours.ends
    inside = low - ROUND_OFF <= ours.value <= high + ROUND_OFF
    return inside and start <= high + ROUND_OFF and end >= low - ROUND_OFF


def above(comparison: Comparison) -> bool:
    """Whether the first sample of a comparison lies above the second one, with p < 0.01."""
    p = comparison.p
    return comparison.difference.value > 0.0 and p is not None and p < SIGNIFICANT


@dataclass(frozen=True)
class Number(DecidableClaim):
    """Claim: the mean of a metric is near a published number."""

    text: str
    source: Source | Pool
    published: float
    tolerance: float = 0.20
    metric: Metric = round_trips

    def _verdict(self, results: Results) -> Verdict:
        ours = estimate(sample(results, self.source, self.metric))
        return self.published, ours, within(ours, *band(self)), None

    def effects(self, results: Results) -> list[Effect]:
        """The mean lies in the band."""
        return [mean_effect(sample(results, self.source, self.metric), *band(self))]


@dataclass(frozen=True)
class Below(DecidableClaim):
    """Claim: the mean of the round trips is less than a published bound."""

    text: str
    source: Source
    bound: float

    def _verdict(self, results: Results) -> Verdict:
        ours = estimate(sample(results, self.source, round_trips))
        return f"< {self.bound:g}", ours, ours.value < self.bound, None

    def effects(self, results: Results) -> list[Effect]:
        """The mean lies below the bound."""
        return [mean_effect(sample(results, self.source, round_trips), -math.inf, self.bound)]


@dataclass(frozen=True)
class Share(DecidableClaim):
    """Claim: a share lies in a published range, 10 points allowed on either side.

    Of several sources, the one farthest from the range speaks for all.
    """

    text: str
    sources: tuple[Source | Pool, ...]
    published: tuple[float, float]
    metric: Metric = on_path

    def _verdict(self, results: Results) -> Verdict:
        low, high = self.published
        shares = [estimate(sample(results, each, self.metric)) for each in self.sources]
        worst = max(shares, key=lambda ours: abs(ours.value - (low + high) / 2.0))
        said = low if low == high else f"{low:g} to {high:g}"
        return said, worst, within(worst, low - POINTS, high + POINTS), None

    def effects(self, results: Results) -> list[Effect]:
        """Every share lies in the range, 10 points allowed."""
        low, high = self.published
        return [
            mean_effect(sample(results, each, self.metric), low - POINTS, high + POINTS)
            for each in self.sources
        ]


@dataclass(frozen=True)
class Ratio(DecidableClaim):
    """Claim: the ratio of two means is near a published number."""

    text: str
    numerator: Source | Pool
    denominator: Source | Pool
    published: float
    tolerance: float = 0.20
    metric: Metric = round_trips

    def _verdict(self, results: Results) -> Verdict:
        ours = compare(*both(results, self.numerator, self.denominator, self.metric)).ratio
        return self.published, ours, ours is not None and within(ours, *band(self)), None

    def effects(self, results: Results) -> list[Effect]:
        """The ratio lies in the band."""
        sides = both(results, self.numerator, self.denominator, self.metric)
        return [Effect(*sides, *band(self))]


def band(claim: Number | Ratio) -> tuple[float, float]:
    """The numbers that are near the published one."""
    margin = claim.tolerance * claim.published
    return claim.published - margin, claim.published + margin


@dataclass(frozen=True)
class Order(DecidableClaim):
    """Claim: one sample lies above another one, in every pair; shown is the least ratio."""

    text: str
    pairs: tuple[tuple[Source, Source], ...]
    """Higher, lower."""
    metric: Metric = round_trips

    def _verdict(self, results: Results) -> Verdict:
        sides = [present_pairs(results, *each, self.metric) for each in self.pairs]
        if not all(len(higher) for higher, _ in sides):
            return "> 1", None, False, None
        comparisons = [compare(*each) for each in sides]
        ratios = [each.ratio for each in comparisons if each.ratio is not None]
        least = min(ratios, key=lambda ratio: ratio.value, default=None)
        largest = max((each.p for each in comparisons if each.p is not None), default=None)
        return "> 1", least, all(map(above, comparisons)), largest

    def effects(self, results: Results) -> list[Effect]:
        """In every pair one lies above the other."""
        sides = (present_pairs(results, *each, self.metric) for each in self.pairs)
        return [order_effect(*each) for each in sides]


@dataclass(frozen=True)
class NoDifference(DecidableClaim):
    """Claim: two samples do not differ (Mann-Whitney p >= 0.05); shown is their ratio."""

    text: str
    one: Source
    other: Source
    metric: Metric = round_trips

    def _verdict(self, results: Results) -> Verdict:
        comparison = compare(*both(results, self.one, self.other, self.metric))
        same = comparison.p is None or comparison.p >= INDISTINCT
        return 1.0, comparison.ratio, same, comparison.p

    def effects(self, results: Results) -> list[Effect]:
        """The two means are equivalent."""
        sides = both(results, self.one, self.other, self.metric)
        return [Effect(*sides, 1.0 - MARGIN, 1.0 + MARGIN)]


@dataclass(frozen=True)
class Contrast(DecidableClaim):
    """Claim: a number of each seed, such as a slope, is larger in one place than another."""

    text: str
    sources: tuple[Experiment, ...]
    contrast: Callable[[Results], tuple[list[float], list[float]]]
    """Larger, smaller: each a number for each seed."""

    def _verdict(self, results: Results) -> Verdict:
        comparison = compare(*self.contrast(results))
        return "> 1", comparison.ratio, above(comparison), comparison.p

    def effects(self, results: Results) -> list[Effect]:
        """The mean of the larger numbers lies above the other."""
        return [order_effect(*self.contrast(results))]


def both(
    results: Results, one: Source | Pool, other: Source | Pool, metric: Metric
) -> tuple[list[float], list[float]]:
    """The metric of both sources for each seed."""
    return sample(results, one, metric), sample(results, other, metric)


def present_pairs(
    results: Results, one: Source, other: Source, metric: Metric
) -> tuple[list[float], list[float]]:
    """The metric of both sources, for each seed under which both have one."""
    pairs = zip(*both(results, one, other, metric), strict=True)
    finite = [(a, b) for a, b in pairs if not (math.isnan(a) or math.isnan(b))]
    return [a for a, _ in finite], [b for _, b in finite]
