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


def test_the_betas_are_the_decades_of_the_report():
    assert len(BETAS) == 8
    assert (BETAS[0], BETAS[-1]) == (1e-5, 1e2)


def test_the_best_beta_is_found_with_its_interval(results):
    clear = BestBeta("best", SWEEP, 1e-2).judge(results(**{"0.01": 120}))
    assert (clear.ours, clear.low, clear.high, clear.reproduced) == (0.01, 0.01, 0.01, True)
    other = BestBeta("best", SWEEP, 1e-2).judge(results(**{"0.001": 120}))
    assert (other.ours, other.reproduced) == (0.001, False)


def test_an_optimum_at_the_edge_is_not_inside(results):
    assert OptimumInsideRange("inside", SWEEP).judge(results(**{"0.01": 120})).reproduced
    assert not OptimumInsideRange("inside", SWEEP).judge(results(**{"1e-05": 120})).reproduced
    assert not OptimumInsideRange("inside", SWEEP).judge(results(**{"100": 120})).reproduced


def test_every_other_beta_must_be_below(results):
    claim = OtherBetasBelow("below", SWEEP, SGIKF)
    assert claim.judge(results(**{"0.01": 120})).reproduced
    found = claim.judge(results(**{"0.01": 120, "0.1": 110}))
    assert (found.ours, found.reproduced) == (pytest.approx(1.1), False)
