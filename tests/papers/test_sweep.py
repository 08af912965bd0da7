"""What is said about the best beta."""

import pytest

from baselines.papers.cells import Cell
from baselines.papers.sweep import BETAS, Inside, Optimum, OthersBelow, Sweep

SWEEP = Sweep("es1")
SGIKF = Cell("es1", "ssgikf")


@pytest.fixture
def results(episodes):
    """Every beta gives about 50 round trips, these give others; SGIKF gives about 100."""

    def make(**others):
        levels = dict.fromkeys(SWEEP.cells, 50) | {SGIKF: 100}
        levels |= {SWEEP.at(float(beta)): level for beta, level in others.items()}
        return {
            cell: episodes(cell, [level + step for step in range(-4, 5)])
            for cell, level in levels.items()
        }

    return make


def test_the_betas_are_the_decades_of_the_report():
    assert len(BETAS) == 8
    assert (BETAS[0], BETAS[-1]) == (1e-5, 1e2)


def test_the_best_beta_is_found_with_its_interval(results):
    clear = Optimum("best", SWEEP, 1e-2).judge(results(**{"0.01": 120}))
    assert (clear.ours, clear.low, clear.high, clear.reproduced) == (0.01, 0.01, 0.01, True)
    other = Optimum("best", SWEEP, 1e-2).judge(results(**{"0.001": 120}))
    assert (other.ours, other.reproduced) == (0.001, False)


def test_an_optimum_at_the_edge_is_not_inside(results):
    assert Inside("inside", SWEEP).judge(results(**{"0.01": 120})).reproduced
    assert not Inside("inside", SWEEP).judge(results(**{"1e-05": 120})).reproduced
    assert not Inside("inside", SWEEP).judge(results(**{"100": 120})).reproduced


def test_every_other_beta_must_be_below(results):
    claim = OthersBelow("below", SWEEP, SGIKF)
    assert claim.judge(results(**{"0.01": 120})).reproduced
    found = claim.judge(results(**{"0.01": 120, "0.1": 110}))
    assert (found.ours, found.reproduced) == (pytest.approx(1.1), False)
