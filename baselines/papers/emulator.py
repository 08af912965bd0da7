"""An emulator: quadratic regression of what a simulation gives, on points of the unit cube.

It says how probable it is that a simulation at a point gives numbers between some ends. Its error
is that of points that it was not fitted to, and so holds the chance in the simulation as well.

Source: Wood2010 (likelihood from simulated summaries), HoerlKennard1970 (ridge regression).
Not in the papers: the penalty, eight folds, and errors of the numbers that are normal and apart.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np
from scipy.stats import norm

from swarm_forage_env.arrays import Array, Float64

PENALTY, FOLDS = 10.0, 8

Draws = Float64[Array, "draws numbers"]  # points of the unit cube, on which the prior is even


@dataclass(frozen=True)
class Emulator:
    """A regression of several outputs."""

    coefficients: Float64[Array, "terms outputs"]
    errors: Float64[Array, " outputs"]  # standard deviations of the outputs about the regression

    @classmethod
    def fit(
        cls,
        draws: Draws,
        outputs: Float64[Array, "draws outputs"],
        weights: Float64[Array, " draws"],
    ) -> Self:
        """Fit outputs, each draw with a weight, and measure the error on folds left out."""
        x, fold = terms(draws), np.arange(len(draws)) % FOLDS
        residuals = np.empty_like(outputs)
        for k in range(FOLDS):
            out, rest = fold == k, fold != k
            fitted = ridge(x[rest], outputs[rest], weights[rest])
            residuals[out] = outputs[out] - x[out] @ fitted
        return cls(ridge(x, outputs, weights), np.sqrt(weights @ residuals**2 / weights.sum()))

    def chance(
        self, draws: Draws, low: Float64[Array, " outputs"], high: Float64[Array, " outputs"]
    ) -> Float64[Array, " draws"]:
        """The probability at each point that every output lies between its ends."""
        means = terms(draws) @ self.coefficients
        below, above = (norm.cdf((ends - means) / self.errors) for ends in (low, high))
        return np.asarray((above - below).prod(axis=1))


def terms(draws: Draws) -> Float64[Array, "draws terms"]:
    """One, each number, and each product of two, on an axis from -1 to 1."""
    x = 2.0 * draws - 1.0
    one, other = np.triu_indices(x.shape[1])
    return np.column_stack([np.ones(len(x)), x, x[:, one] * x[:, other]])


def ridge(
    x: Float64[Array, "draws terms"],
    outputs: Float64[Array, "draws outputs"],
    weights: Float64[Array, " draws"],
) -> Float64[Array, "terms outputs"]:
    """The coefficients of least weighted squares, with a penalty on all but the constant.

    (X' W X + l I) b = X' W y
    """
    penalty = PENALTY * np.eye(x.shape[1])
    penalty[0, 0] = 0.0
    weighted = x.T * weights
    return np.asarray(np.linalg.solve(weighted @ x + penalty, weighted @ outputs))
