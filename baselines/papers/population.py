"""Population Monte Carlo: draws around the nearest so far, and the weights that undo it.

The first draws fill the prior. Each later generation is drawn from a density about the nearest
draws before it. A draw counts one over the mean density of all generations there, so that weighted
draws stand for the prior, whatever they were drawn around.

Source: Beaumont2009 (populations), Cornuet2012 (weights over all generations).
Not in the papers: a tenth of every later density is the prior, which bounds the weights.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import norm, truncnorm

from swarm_forage_env.arrays import Array, Float64

FIRST, GENERATION, POPULATION = 256, 128, 64
"""Draws from the prior, from each later density, and those that a density is centred on."""

EVEN, NARROWEST = 0.1, 0.02
"""Share of a later density that is the prior; its least width, as a share of the prior's."""

Draws = Float64[Array, "draws numbers"]
"""Points of the unit cube, on which the prior is even."""


@dataclass(frozen=True)
class Density:
    """A density of draws: truncated normals about weighted centres, and a share of the prior."""

    centres: Draws
    weights: Float64[Array, " centres"]
    widths: Float64[Array, " numbers"]

    def __call__(self, draws: Draws) -> Float64[Array, " draws"]:
        """The density at points of the unit cube."""
        below, above = -self.centres / self.widths, (1.0 - self.centres) / self.widths
        inside = norm.cdf(above) - norm.cdf(below)
        away = (draws[:, None] - self.centres) / self.widths
        about = (norm.pdf(away) / self.widths / inside).prod(axis=2) @ self.weights
        return np.asarray(EVEN + (1.0 - EVEN) * about)

    def draw(self, n: int, rng: np.random.Generator) -> Draws:
        """Draw points of the unit cube."""
        about = self.centres[rng.choice(len(self.centres), n, p=self.weights)]
        ends = -about / self.widths, (1.0 - about) / self.widths
        near = truncnorm.rvs(*ends, loc=about, scale=self.widths, random_state=rng)
        even = rng.random(about.shape)
        return np.where(rng.random((n, 1)) < EVEN, even, near)


def weights_of(draws: Draws, densities: Sequence[Density], n: int) -> Float64[Array, " draws"]:
    """The weight 1 / q of each draw among n, from the prior and then from these densities."""
    sizes = np.minimum(GENERATION, n - FIRST - GENERATION * np.arange(len(densities)))
    total = min(FIRST, n) + sum(k * q(draws) for k, q in zip(sizes, densities, strict=True))
    return np.asarray(n / np.broadcast_to(total, len(draws)))


def densities_of(draws: Draws, far: Float64[Array, " draws"]) -> list[Density]:
    """The density of each generation after the first, from the draws before it."""
    made: list[Density] = []
    for n in range(FIRST, len(draws) + 1, GENERATION):
        nearest = np.argsort(far[:n], kind="stable")[:POPULATION]
        centres = draws[nearest]
        share = weights_of(centres, made, n)
        share /= share.sum()
        widths = np.sqrt(share @ (centres - share @ centres) ** 2)
        made.append(Density(centres, share, np.maximum(widths, NARROWEST)))
    return made
