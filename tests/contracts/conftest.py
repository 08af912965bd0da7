"""The contracts of a weighting rule: registered rules keep them, and so do printed examples."""

import numpy as np
import pytest
from numpy.testing import assert_array_equal

import baselines.controllers  # noqa: F401 enters the controllers
from baselines.weighting.rows import RowWeighting
from swarm_forage_env.scenarios import find_scenario
from tests.outside import exchanges

ROW = 2


def random_exchanges(rng, rows):
    """Exchanges about areas that most robots know, of which each has just ended."""
    p = rng.exponential(5.0, (2, rows, 2)).astype(np.float32)
    known = rng.random((2, rows, 2)) < 0.8
    p[~known] = 0.0
    return exchanges(
        rows,
        own_p=p[0],
        heard_p=p[1],
        own_known=known[0],
        heard_known=known[1],
        disagreement=rng.random((rows, 2)),
        own_distance=rng.random((rows, 2)),
        heard_distance=rng.random((rows, 2)),
        range=rng.random(rows),
        n_averaged=rng.integers(0, 60, rows),
        goal=np.eye(3)[rng.integers(0, 3, rows)],
    )


@pytest.fixture(scope="session")
def on_arrays():
    """A rule of foraging as a function of arrays, compiled or not."""

    def make(part):
        scenario = find_scenario("es1")
        return part if callable(part) else RowWeighting(part.layer(scenario))

    return make


@pytest.fixture(scope="session")
def weighs_by_shares():
    """Assert that every weight is a share, in single precision."""

    def check(rule):
        g = rule(random_exchanges(np.random.default_rng(0), 1000))
        assert g.shape == (1000, 2)
        assert g.dtype == np.float32
        assert np.all((g >= 0.0) & (g <= 1.0))
        assert np.count_nonzero(g) > 500  # a gate refuses most of what is drawn at random
        assert 0.0 <= rule.heard_p_share <= 1.0

    return check


@pytest.fixture(scope="session")
def weighs_by_the_own_row():
    """Assert that a robot's weights are the same whatever other robots were told."""

    def check(rule):
        rng = np.random.default_rng(0)
        mine, others = random_exchanges(rng, 5), random_exchanges(rng, 5)
        mine.own_known[ROW] = mine.heard_known[ROW] = True
        others[ROW] = mine[ROW]
        assert_array_equal(rule(mine)[ROW], rule(others)[ROW])

    return check
