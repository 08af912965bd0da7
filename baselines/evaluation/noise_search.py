"""Policies that search by the noise of their actions: what `evaluate` says of them.

A policy that has learned to find areas by its noise drives in circles without it, in some episodes
or in all. It shows as episodes that differ widely, or as a score far below that with noise.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from baselines.evaluation.episode import AnyEpisode, present_values
from baselines.evaluation.experiment_config import ExperimentConfig
from swarm_forage_env.arrays import Array
from swarm_forage_env.foraging.episode import ForagingEpisode

WIDE, SHARE = 40.0, 0.2
"""Standard deviation of round trips between episodes, and its share of their mean, from which
episodes differ widely: hand-written controllers have 4 to 12 in es1, of 60 to 250."""

FAR = 0.8  # share of the score with noise below which the one without is far below it

CHANCE = "policy.chance"


def noise_lines(
    configurations: Sequence[ExperimentConfig], episodes: Sequence[Sequence[AnyEpisode]]
) -> Iterator[str]:
    """A line for each policy that acts without noise and searches by it; none in other tasks."""
    if not isinstance(episodes[0][0], ForagingEpisode):
        return
    trips = [np.array(present_values(own, "round_trips")) for own in episodes]
    parameters = [each.controller.parameters for each in configurations]
    for configuration, own, mine in zip(configurations, parameters, trips, strict=True):
        noisy = own | {CHANCE: True}
        with_noise = [t.mean() for p, t in zip(parameters, trips, strict=True) if p == noisy]
        if own.get(CHANCE) is False and (reason := _reason(mine, *with_noise[:1])):
            yield (
                f"policy {configuration.label} searches by its noise: {reason}; compare it with"
                f" {configuration.label},chance=true"
            )


def _reason(trips: Array, with_noise: float = 0.0) -> str:
    """Why a policy without noise seems to search by it; empty if it does not."""
    spread = trips.std(ddof=1) if len(trips) > 1 else 0.0
    if spread > max(WIDE, SHARE * trips.mean()):
        return f"its episodes differ by {spread:.0f} round trips (standard deviation)"
    if trips.mean() < FAR * with_noise:
        return f"it makes {trips.mean():.0f} round trips without, and {with_noise:.0f} with it"
    return ""
