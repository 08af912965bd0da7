"""The claims and figures of ANTS, Section 5, one by one."""

import pytest

from baselines.papers.ants2008 import LOCAL, PAPER, SIZES, experiment_of_size, slopes
from baselines.papers.beta_sweep import BestBeta
from baselines.papers.claim_types import Contrast, Order
from baselines.papers.experiments import Experiment, recruitment_time, round_trips

MOST = "ssgiff:beta=0.001"
"""Local communication: the single Fermi filter with the published beta."""


def at(controller, *sizes):
    """The experiments of a controller with groups of these sizes."""
    return [Experiment("ants2008", controller, (f"task.n_robots={size}",)) for size in sizes]


def pairs(one, other, *sizes):
    """The experiments of two controllers, size by size."""
    return list(zip(at(one, *sizes), at(other, *sizes), strict=True))


def test_each_claim_is_of_the_experiments_that_it_names():
    local, other, silent = (Experiment("ants2008", each) for each in (MOST, "global", "covariance"))
    found = {
        each.text.removeprefix("ants2008: "): (
            each.metric, list(each.pairs) if isinstance(each, Order) else [each.experiments]
        )
        for each in PAPER.claims
        if hasattr(each, "metric")
    }  # fmt: skip
    assert found == {
        "no odometry error above local, at every group size":
            (round_trips, pairs("no-error", MOST, *SIZES)),
        "local above no communication, at every group size":
            (round_trips, pairs(MOST, "nc", *SIZES)),
        "local and covariance knowledge do not differ significantly":
            (round_trips, [(local, silent)]),
        "local above global": (round_trips, [(local, other)]),
        "recruitment of 2 robots does not differ with communication":
            (recruitment_time, pairs("nc", MOST, 2)),
        "recruitment of 30 and more robots faster with communication":
            (recruitment_time, pairs("nc", MOST, 30, 40, 50)),
    }  # fmt: skip
    (best,) = (each for each in PAPER.claims if isinstance(each, BestBeta))
    assert (best.sweep.scenario, best.sweep.filter) == ("ants2008", "ssgiff")
    (bend,) = (each for each in PAPER.claims if isinstance(each, Contrast))
    assert list(bend.experiments) == at(MOST, *SIZES)


def test_the_group_at_the_bend_belongs_to_both_slopes(episodes):
    """Least squares by hand: 10 robots bring in 10, all other groups nothing."""
    results = {
        experiment_of_size(LOCAL, size): episodes(
            experiment_of_size(LOCAL, size), [10 * (size == 10), 20 * (size == 10)]
        )
        for size in SIZES
    }
    below, above = slopes(results)
    first = 10 * (10 - 17 / 3) / (98 / 3)  # sizes 2, 5, 10: mean 17/3, squares about it 98/3
    assert below == pytest.approx([first, 2 * first])
    second = 10 * (10 - 27.5) / 1187.5  # sizes 10 to 50: mean 27.5, squares about it 1187.5
    assert above == pytest.approx([second, 2 * second])
