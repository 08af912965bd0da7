"""A sweep of beta, and what the papers say about its optimum."""

from dataclasses import dataclass

import numpy as np

from baselines.evaluation.statistics import CONFIDENCE, Estimate, compare
from baselines.papers.cells import Best, Cell, Results, Source, round_trips, sample
from baselines.papers.findings import Finding, above, finding

BETAS = tuple(10.0**decade for decade in range(-5, 3))
"""Steepness of the Fermi function [1/cm]: "8 values in [1e-5, 100]" (TR 6.1.2)."""

RESAMPLES = 2000
"""Of the seeds, for the interval of the best beta."""


@dataclass(frozen=True)
class Sweep:
    """One filter under every beta."""

    scenario: str
    filter: str = "ssgiff"

    @property
    def cells(self) -> tuple[Cell, ...]:
        """One for each beta, in their order."""
        return tuple(self.at(beta) for beta in BETAS)

    @property
    def best(self) -> Best:
        """The best beta, chosen on other seeds than those it is scored on."""
        return Best(self.cells)

    def at(self, beta: float) -> Cell:
        """The filter under this beta."""
        return Cell(self.scenario, f"{self.filter}:beta={beta:g}")

    def optimum(self, results: Results) -> Estimate:
        """The beta with the most round trips over all seeds; its interval resamples the seeds."""
        trips = np.array([sample(results, cell, round_trips) for cell in self.cells])
        n_seeds = trips.shape[1]
        draws = np.random.default_rng(0).integers(n_seeds, size=(RESAMPLES, n_seeds))
        winners = trips[:, draws].mean(axis=2).argmax(axis=0)
        tail = 50.0 * (1.0 - CONFIDENCE)
        low, high = np.percentile(winners, [tail, 100.0 - tail], method="nearest")
        interval = BETAS[int(low)], BETAS[int(high)]
        return Estimate(BETAS[int(trips.mean(axis=1).argmax())], interval, n_seeds)


@dataclass(frozen=True)
class Optimum:
    """The best beta is the published one."""

    text: str
    sweep: Sweep
    published: float

    @property
    def cells(self) -> tuple[Cell, ...]:
        """The cells it needs."""
        return self.sweep.cells

    def judge(self, results: Results) -> Finding:
        """Measure it."""
        ours = self.sweep.optimum(results)
        same = bool(np.isclose(ours.value, self.published))
        return finding(self.text, self.published, ours, same)


@dataclass(frozen=True)
class Inside:
    """The best beta is neither the smallest nor the largest one."""

    text: str
    sweep: Sweep

    @property
    def cells(self) -> tuple[Cell, ...]:
        """The cells it needs."""
        return self.sweep.cells

    def judge(self, results: Results) -> Finding:
        """Measure it."""
        ours = self.sweep.optimum(results)
        inside = BETAS[0] < ours.value < BETAS[-1]
        return finding(self.text, f"{BETAS[1]:g} to {BETAS[-2]:g}", ours, inside)


@dataclass(frozen=True)
class OthersBelow:
    """Every beta but the best one stays below a reference; shown is the largest ratio to it."""

    text: str
    sweep: Sweep
    reference: Source

    @property
    def cells(self) -> tuple[Cell, ...]:
        """The cells it needs."""
        return self.sweep.cells + self.reference.cells

    def judge(self, results: Results) -> Finding:
        """Measure it."""
        best = self.sweep.at(self.sweep.optimum(results).value)
        base = sample(results, self.reference, round_trips)
        others = [sample(results, cell, round_trips) for cell in self.sweep.cells if cell != best]
        found = [compare(base, trips) for trips in others]
        ratios = [ratio for trips in others if (ratio := compare(trips, base).ratio)]
        largest = max(ratios, key=lambda ratio: ratio.value, default=None)
        p = max((each.p for each in found if each.p is not None), default=None)
        return finding(self.text, "< 1", largest, all(map(above, found)), p)
