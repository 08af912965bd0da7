"""What is said about the best beta."""

import pytest

from baselines.papers.beta_sweep import (
    BETAS,
    BestBeta,
    BetaSweep,
    OptimumInsideRange,
    OtherBetasBelow,
)
from baselines.papers.experiments import Experiment

SWEEP = BetaSweep("es1")
SGIKF = Experiment("es1", "ssgikf")


@pytest.fixture
def results(episodes):
    """Every beta gives about 50 round trips, these give others; SGIKF gives about 100."""

    def make(**others):
        levels = dict.fromkeys(SWEEP.experiments, 50) | {SGIKF: 100}
        levels |= {SWEEP.at(float(beta)): level for beta, level in others.items()}
        return {
            experiment: episodes(experiment, [level + step for step in range(-4, 5)])
            for experiment, level in levels.items()
        }

    return make


def test_the_best_beta_is_found_with_its_interval(results):
    for beta, reproduced in ((0.01, True), (0.001, False)):
        found = BestBeta("best", SWEEP, 1e-2).judge(results(**{f"{beta}": 120}))
        assert (found.ours, found.low, found.high) == (beta,) * 3
        assert found.reproduced == reproduced


def test_the_betas_are_those_of_one_filter_in_one_scenario():
    decades = [1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1.0, 10.0, 100.0]
    assert list(BETAS) == pytest.approx(decades)
    assert SWEEP.at(0.001) == Experiment("es1", "ssgiff:beta=0.001")
    assert BetaSweep("es2", "dsgiff").at(10.0) == Experiment("es2", "dsgiff:beta=10")
    names = ["1e-05", "0.0001", "0.001", "0.01", "0.1", "1", "10", "100"]
    assert [each.controller for each in SWEEP.experiments] == [f"ssgiff:beta={n}" for n in names]
    assert SWEEP.best.experiments == SWEEP.experiments


@pytest.mark.parametrize(
    ("n_seeds", "n_good", "n_draws", "is_in"),
    [
        # Of n seeds, the other beta wins in k: it is the best one where at least m of the n that
        # are drawn are among these. The chance of that is a binomial one, worked by hand.
        (10, 2, 5, True),  # 3.3 %, more than the 2.5 % that an interval leaves out on a side
        (10, 1, 3, True),  # 7.0 %
        (6, 2, 5, False),  # 1.8 %
        (10, 1, 4, False),  # 1.3 %
    ],
)
@pytest.mark.parametrize("other", [1e-4, 1.0])
def test_the_interval_leaves_out_what_is_best_in_less_than_a_fortieth_of_the_draws(
    episodes, n_seeds, n_good, n_draws, is_in, other
):
    good = int(100 * n_seeds / (n_draws - 0.5))
    trips = {experiment: [0] * n_seeds for experiment in SWEEP.experiments}
    trips[SWEEP.at(1e-2)] = [100] * n_seeds
    trips[SWEEP.at(other)] = [good] * n_good + [0] * (n_seeds - n_good)
    results = {experiment: episodes(experiment, each) for experiment, each in trips.items()}
    found = SWEEP.optimum(results)
    assert found.value == 1e-2
    assert found.n == n_seeds
    ends = sorted((other, 1e-2)) if is_in else [1e-2, 1e-2]
    assert found.interval == pytest.approx(ends)


def test_an_optimum_may_be_next_to_the_edge(results):
    for beta, inside in (("1e-05", False), ("0.0001", True), ("10", True), ("100", False)):
        found = OptimumInsideRange("inside", SWEEP).judge(results(**{beta: 120}))
        assert (found.reproduced, found.ours) == (inside, pytest.approx(float(beta)))


def test_of_the_other_betas_the_one_nearest_to_the_reference_is_shown(results):
    claim = OtherBetasBelow("below", SWEEP, SGIKF)
    found = claim.judge(results(**{"0.01": 120, "0.1": 80, "1": 20}))
    assert (found.reproduced, found.ours) == (True, pytest.approx(0.8))
    near = claim.judge(results(**{"0.01": 120, "0.1": 98}))
    assert not near.reproduced
    assert near.p > found.p
