"""The result of a claim: the published value, ours, and whether they agree."""

from dataclasses import asdict, dataclass
from typing import Any, Protocol

from baselines.evaluation.statistics import Comparison, Estimate, mean_interval
from baselines.papers.experiments import Experiment, Results

SIGNIFICANT = 0.01
"""An ordering holds if its Mann-Whitney p is below this."""

ROUND_OFF = 1e-9
"""A number on the edge of its band is inside."""


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

    def as_row(self) -> dict[str, Any]:
        """The result as a dictionary for JSON."""
        return {name: value for name, value in asdict(self).items() if name != "p"}


class Claim(Protocol):
    """Protocol of a claim: a statement of a paper that can be measured here."""

    @property
    def text(self) -> str:
        """The claim in words."""
        ...

    @property
    def experiments(self) -> tuple[Experiment, ...]:
        """The experiments whose episodes are used."""
        ...

    def judge(self, results: Results) -> ClaimResult:
        """Judge the claim on these results."""
        ...


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


def estimate(values: list[float]) -> Estimate:
    """The mean of a sample with its interval."""
    found = mean_interval(values)
    if found is None:
        raise ValueError("a claim needs at least one episode")
    return found


def within(ours: Estimate, low: float, high: float) -> bool:
    """Whether the value lies in the band, and its interval touches the band."""
    start, end = ours.interval or (ours.value, ours.value)
    inside = low - ROUND_OFF <= ours.value <= high + ROUND_OFF
    return inside and start <= high + ROUND_OFF and end >= low - ROUND_OFF


def above(found: Comparison) -> bool:
    """Whether the first sample of a comparison lies above the second one, with p < 0.01."""
    return found.difference.value > 0.0 and found.p is not None and found.p < SIGNIFICANT
