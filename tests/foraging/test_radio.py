"""Who hears whom over the radio, and how well range and bearing are measured."""

import math

import numpy as np
import pytest
from scipy import stats

from swarm_forage_env.equations.radio import mean_board_range

NO_LOSS = {"loss_near": 0.0, "loss_far": 0.0}
QUIET = {**NO_LOSS, "range_noise": 0.0, "bearing_noise": 0.0}


@pytest.mark.parametrize(
    "wheels", [(0.06, 0.06), (0.06, -0.06), (-0.03, 0.03), (0.0, 0.06), (0.06, 0.0)]
)
def test_a_receiver_at_rest_averages_its_frames_and_one_that_moves_or_turns_does_not(block, wheels):
    robots = block([(0, 0, 0), (0.1, 0, 0)], n_worlds=2000, frames=10, **NO_LOSS)
    robots.state.wheels[1::2] = wheels
    heard, _ = robots.receive()
    assert heard.n_averaged[0::2, 0].tolist() == [10] * 2000
    assert heard.n_averaged[1::2, 0].tolist() == [1] * 2000
    at_rest, moving = (heard.range_bearing[end::2, 0, 0].var() for end in (0, 1))
    assert moving / at_rest == pytest.approx(10.0, rel=0.15)


def test_the_real_board_measures_between_the_rims(block, fresh):
    robots = block([(0, 0, 0), (0.12, 0, 0)], n_worlds=2000, frames=10, range_model="board")
    heard, valid = robots.receive()
    ranges = heard.range_bearing[valid][:, 0]
    assert ranges.min() > 0.07
    streams = fresh(1)
    alone = [mean_board_range(0.05, streams, 0, 10) for _ in range(2000)]
    assert np.median(ranges) == pytest.approx(0.07 + np.median(alone), rel=0.02)


def test_of_more_messages_than_slots_each_is_heard_equally_often(block, believable):
    ring = [(0.1 * math.cos(a), 0.1 * math.sin(a), 0) for a in np.arange(7) * 2 * math.pi / 7]
    heard, valid = block([(0, 0, 0), *ring], n_worlds=4000, **QUIET).receive()
    receiver = heard.sender[0::8]
    assert valid[0::8].all()
    assert receiver.shape[1] == 4
    assert all(len(set(senders)) == 4 for senders in receiver.tolist())
    counts = np.bincount(receiver.ravel(), minlength=8)
    assert counts[0] == 0
    # Four of seven without repeats vary less than independent draws: the factor is 1 - 3/6.
    chi2 = np.sum((counts[1:] - 4000 * 4 / 7) ** 2) / (4000 * 4 / 7)
    believable(stats.chi2(6).sf(chi2 / 0.5))
