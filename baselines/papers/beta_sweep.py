"""A sweep of the Fermi steepness beta, and the claims about its optimum."""

from dataclasses import dataclass

import numpy as np

from baselines.evaluation.statistics import Estimate, compare, middle
from baselines.papers.claim_types import Above, DecidableClaim, Effect, Verdict, order_effect
from baselines.papers.experiments import (
    CrossValidatedBest,
    Experiment,
    Results,
    Source,
    round_trips,
    sample,
)

BETAS = tuple(10.0**decade for decade in range(-5, 3))
"""Steepness of the Fermi function [1/cm]: "8 values in [1e-5, 100]" (TR 6.1.2)."""

RESAMPLES = 2000  # bootstrap samples of the seeds, for the interval of the best beta


@dataclass(frozen=True)
class BetaSweep:
    """Experiments of one filter with every beta."""

    scenario: str
    filter: str = "ssgiff"

    @property
    def experiments(self) -> tuple[Experiment, ...]:
        """One experiment for each beta, in the order of `BETAS`."""
        return tuple(self.at(beta) for beta in BETAS)

    @property
    def best(self) -> CrossValidatedBest:
        """Best beta by cross-validation over seeds."""
        return CrossValidatedBest(self.experiments)

    def at(self, beta: float) -> Experiment:
        """Return the experiment of the filter with this beta."""
        return Experiment(self.scenario, f"{self.filter}:beta={beta:g}")

    def optimum(self, results: Results) -> Estimate:
        """Return the beta with the most round trips; its interval is a bootstrap over seeds."""
        trips = np.array([sample(results, each, round_trips) for each in self.experiments])
        n_seeds = trips.shape[1]
        draws = np.random.default_rng(0).integers(n_seeds, size=(RESAMPLES, n_seeds))
        winners = trips[:, draws].mean(axis=2).argmax(axis=0)
        low, high = map(int, middle(winners, "nearest"))
        best = BETAS[int(trips.mean(axis=1).argmax())]
        return Estimate(best, (BETAS[low], BETAS[high]), n_seeds)


@dataclass(frozen=True)
class BestBeta(DecidableClaim):
    """Claim: the best beta is the published one."""

    text: str
    sweep: BetaSweep
    published: float

    def _verdict(self, results: Results) -> Verdict:
        ours = self.sweep.optimum(results)
        return self.published, ours, bool(np.isclose(ours.value, self.published)), None

    def effects(self, results: Results) -> list[Effect]:
        """Return the effects: the published beta makes more round trips than every other."""
        best = self.sweep.at(self.published)
        trips = sample(results, best, round_trips)
        others = (each for each in self.sweep.experiments if each != best)
        return [order_effect(trips, sample(results, each, round_trips)) for each in others]


@dataclass(frozen=True)
class OptimumInsideRange(DecidableClaim):
    """Claim: the best beta is neither the smallest nor the largest one."""

    text: str
    sweep: BetaSweep

    def _verdict(self, results: Results) -> Verdict:
        ours = self.sweep.optimum(results)
        inside = BETAS[0] < ours.value < BETAS[-1]
        return f"{BETAS[1]:g} to {BETAS[-2]:g}", ours, inside, None

    def effects(self, results: Results) -> list[Effect]:
        """Return the effects: the best beta inside makes more round trips than either end."""
        first, *inside, last = self.sweep.experiments
        best = sample(results, CrossValidatedBest(tuple(inside)), round_trips)
        return [order_effect(best, sample(results, end, round_trips)) for end in (first, last)]


@dataclass(frozen=True)
class OtherBetasBelow(Above):
    """Claim: every beta but the best is below a reference; the largest ratio is shown."""

    text: str
    sweep: BetaSweep
    reference: Source

    def _verdict(self, results: Results) -> Verdict:
        ratios = [compare(each.base, each.values).ratio for each in self.effects(results)]
        largest = max(filter(None, ratios), key=lambda ratio: ratio.value, default=None)
        _, _, is_below, p = super()._verdict(results)
        return "< 1", largest, is_below, p

    def effects(self, results: Results) -> list[Effect]:
        """Return the effects: the reference makes more round trips than every beta but the best."""
        best = self.sweep.at(self.sweep.optimum(results).value)
        base = sample(results, self.reference, round_trips)
        others = (each for each in self.sweep.experiments if each != best)
        return [order_effect(base, sample(results, each, round_trips)) for each in others]
