"""What an episode is judged by, in cases worked by hand."""

import numpy as np

from swarm_forage_env.foraging.episode import LocalisationErrorMeter
from swarm_forage_env.foraging.metrics import knows_both_areas_share, recruited_at
from tests.beliefs import localisation_error


def test_the_share_on_the_path_is_the_mean_over_the_second_half():
    # Ten ticks, of which five count; two robots on the path for all and for one of them.
    path_ticks = np.array([5, 1, 0, 0], np.int64)
    np.testing.assert_allclose(knows_both_areas_share(path_ticks, 2, 10), [0.6, 0.0])
    # Of an odd number of ticks the second half is the longer one.
    np.testing.assert_allclose(knows_both_areas_share(np.array([6], np.int64), 1, 11), [1.0])
    assert knows_both_areas_share(np.zeros(2, np.int64), 1, 0).tolist() == [0.0]


def test_robots_report_what_their_estimator_knows_and_the_next_tick_counts_it(running):
    loop = running("es1", [0], duration=120.0)
    state, expected = loop.world.state, np.zeros(10, np.int64)
    for tick in range(1, 1201):
        known = loop.situation.known
        np.testing.assert_array_equal(state.report.known, known)
        expected += known.all(axis=1) & (tick > 600)
        loop.step()
    np.testing.assert_array_equal(state.path_ticks, expected)
    assert expected.sum() > 0


def test_recruits_are_told_in_the_order_in_which_they_had_visited_both_areas():
    first_visit = np.array([[[10, 40], [30, -1], [5, 6]], [[-1, -1]] * 3], np.int64)
    assert recruited_at(first_visit, 0.5) == [(3.0, 20.0), ()]


def test_the_localisation_error_is_that_of_the_robots_that_are_meant_about_what_they_know(running):
    loop = running("two-nests", [0, 1], "kinematic", "ssgikf")
    is_meant = np.random.default_rng(5).random(loop.world.robots.shape) < 0.7
    meter, errors, known = LocalisationErrorMeter(loop, is_meant), np.zeros(2), np.zeros(2)
    for _ in range(1500):
        loop.step()
        meter.sample()
        mask = is_meant.reshape(-1, 1)
        errors += (localisation_error(loop) * mask).reshape(2, -1).sum(axis=1)
        known += ((loop.situation.known > 0.0) & mask).reshape(2, -1).sum(axis=1)
    assert (known > 1000).all()
    np.testing.assert_allclose(meter.means(), errors / known, rtol=1e-12)
