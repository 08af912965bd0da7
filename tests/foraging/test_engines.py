"""Two engines, one swarm: rigid and kinematic agree in what an episode is judged by."""

import numpy as np
from scipy import stats

SEEDS = range(24)
DURATION = 600.0


def round_trips(running, physics):
    loop = running("es1", SEEDS, physics, controller="ssgikf", duration=DURATION)
    for _ in range(loop.world.scenario.n_ticks):
        loop.step()
    return loop.world.robots["round_trips"].sum(axis=1)


def test_rigid_and_kinematic_agree_in_round_trips(running):
    rigid, kinematic = round_trips(running, "rigid"), round_trips(running, "kinematic")
    assert min(rigid.mean(), kinematic.mean()) > 5.0
    assert stats.mannwhitneyu(rigid, kinematic).pvalue > 0.01
    (low, high), (other_low, other_high) = interval(rigid), interval(kinematic)
    assert low <= other_high
    assert other_low <= high


def interval(trips):
    """The 95 % bootstrap interval of the mean."""
    means = np.random.default_rng(0).choice(trips, (5000, len(trips))).mean(axis=1)
    return np.percentile(means, [2.5, 97.5])
