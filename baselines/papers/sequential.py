"""Group sequential tests: each claim is decided by as many episodes as it needs.

Episodes are added in blocks, both sides of a comparison under the same seeds. After each block
every open claim is tested again (`decision_of`), `len(LOOKS)` times at most. Each interval thus
has the level 1 - 0.05 / (looks x effects): the probability that any interval of a claim misses at
any look is at most 5 % (Bonferroni; LanDeMets1983 spend the same 5 % less evenly). The 5 % are per
claim. The best of several, such as the best beta, is chosen by cross-validation
(`CrossValidatedBest`), or by the same episodes if the claim says so.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy import stats

from baselines.evaluation.statistics import fieller_interval
from baselines.papers.claim_types import MARGIN, Claim, DecidableClaim, Effect
from baselines.papers.experiments import Experiment, Results

LOOKS = (30, 60, 120, 240, 400)  # episodes of an experiment at each look
ERROR = 0.05  # probability that a claim is decided wrongly, at most

Decision = Literal["holds", "fails", "equivalent", "undecided"]


@dataclass(frozen=True)
class Decided:
    """Decision on one claim: a row of the table."""

    claim: str
    range: str  # range in which the paper places the effect
    ours: float  # mean, or ratio of the means, of the effect that decides the claim
    low: float
    high: float  # its interval; infinite where the mean of the base may be zero
    n: int  # episodes of each experiment
    resolved: float
    """Half of the 95 % interval that 30 unpaired episodes give, as a share of the effect."""
    decision: Decision


def resolution(effect: Effect, n: int) -> float:
    """Return half of the 95 % interval of an effect for n unpaired episodes a side.

    It is a share of the effect, to first order; NaN if a mean is zero or no episode differs.
    """
    sides = np.array([effect.values, effect.base])
    means = sides.mean(axis=1)
    if not (means.all() and np.ptp(sides, axis=1).any()):
        return math.nan
    of_both = math.hypot(*(sides.std(axis=1, ddof=1) / means))
    return float(stats.norm.ppf(0.975)) * of_both / math.sqrt(n)


def interval_of(effect: Effect, level: float) -> tuple[float, float]:
    """Return the interval of an effect at this level; infinite if all values are equal.

    That of a share of episodes is exact: Student's would have length zero for 30 of 30.

    Source: ClopperPearson1934.
    """
    if effect.is_mean and {*effect.values} <= {0.0, 1.0}:
        count, n = int(sum(effect.values)), len(effect.values)
        low, high = stats.binomtest(count, n).proportion_ci(level, method="exact")
        return float(low), float(high)
    if len({*effect.values, *effect.base}) == 1:
        return -math.inf, math.inf
    return fieller_interval(effect.values, effect.base, level)


def decision_of(effect: Effect, low: float, high: float) -> Decision:
    """Return the decision on an effect by its interval; equivalent: within 3 % of equality."""
    if effect.low <= low and high <= effect.high:
        return "holds"
    if high < effect.low or low > effect.high:
        return "fails"
    one_sided = (effect.low, effect.high) == (1.0, math.inf)
    if one_sided and low >= 1.0 - MARGIN and high <= 1.0 + MARGIN:
        return "equivalent"
    return "undecided"


RANKS: tuple[Decision, ...] = ("fails", "undecided", "equivalent", "holds")
"""Decisions by rank: a claim gets the first that any of its effects has."""


def decide(claim: DecidableClaim, results: Results, n: int) -> Decided:
    """Decide a claim from n episodes of each experiment, at one of the looks."""
    effects = claim.effects(results)
    level = 1.0 - ERROR / (len(LOOKS) * len(effects))
    judged = []
    for effect in effects:
        low, high = interval_of(effect, level)
        base = float(np.mean(effect.base))
        ours = float(np.mean(effect.values)) / base if base else math.nan
        numbers = ours, low, high, n, resolution(effect, LOOKS[0])
        judged.append(Decided(claim.text, effect.range, *numbers, decision_of(effect, low, high)))
    return min(judged, key=lambda each: (RANKS.index(each.decision), each.low))


def decide_all(
    claims: Iterable[Claim], run: Callable[[Sequence[Experiment], int], Results]
) -> Iterator[list[Decided]]:
    """Decide claims by as many episodes as they need; `run` runs n of each experiment.

    Yields the decisions on all claims after each look; open claims are undecided. Claims without
    effects, such as published means within standard errors, are left out.
    """
    still = [claim for claim in claims if isinstance(claim, DecidableClaim)]
    decided: dict[DecidableClaim, Decided] = {}
    for n in LOOKS:
        if not still:
            return
        needed = dict.fromkeys(each for claim in still for each in claim.experiments)
        results = run(tuple(needed), n)
        decided |= {claim: decide(claim, results, n) for claim in still}
        still = [claim for claim in still if decided[claim].decision == "undecided"]
        yield list(decided.values())
