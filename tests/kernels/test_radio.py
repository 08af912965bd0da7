"""The range-and-bearing radio: who is heard, and how well the beam is measured."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from swarm_forage_env.kernels.frames import wrap
from swarm_forage_env.kernels.radio import board_range, loss, mean_board_range, mean_error
from swarm_forage_env.neighbours import Neighbours
from swarm_forage_env.scenarios import find_scenario
from swarm_forage_env.sensors.radio import RadioBoard
from swarm_forage_env.state import empty_state
from swarm_forage_env.streams import Cause, streams

QUIET = {
    "loss_near": 0.0,
    "loss_far": 0.0,
    "range_noise": 0.0,
    "bearing_noise": 0.0,
}


@pytest.mark.parametrize(
    ("d", "share"), [(0.0, 0.01), (0.01, 0.01), (0.08, 0.255), (0.15, 0.5), (0.2, 0.5)]
)
def test_loss_rises_linearly_from_one_percent_at_a_centimetre_to_half_at_the_end(d, share):
    assert loss(d, 0.01, 0.15, 0.01, 0.5) == pytest.approx(share)


@given(st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_loss_never_falls_with_distance(a, b):
    assert loss(min(a, b), 0.01, 0.15, 0.01, 0.5) <= loss(max(a, b), 0.01, 0.15, 0.01, 0.5)


@pytest.mark.parametrize("frames", [1, 4, 10])
def test_the_mean_of_n_uniform_errors_has_a_third_of_a_squared_over_n_for_variance(frames, fresh):
    words, a, draws = fresh(1), 0.3, 20_000
    errors = np.array([mean_error(words, 0, frames, a) for _ in range(draws)])
    assert np.abs(errors).max() <= a
    assert abs(errors.mean()) < 4.0 * a / math.sqrt(3.0 * frames * draws)
    assert errors.var() == pytest.approx(a * a / (3.0 * frames), rel=0.05)


@pytest.mark.parametrize(
    ("gap", "median", "low", "high"), [(0.10, 10.2, 1.5, 45.0), (0.15, 19.3, 5.8, 53.0)]
)
def test_the_real_board_misjudges_range_as_measured(gap, median, low, high, fresh):
    words = fresh(1)
    ranges = 100.0 * np.array([board_range(gap, words, 0) for _ in range(40_000)])
    assert np.median(ranges) == pytest.approx(median, rel=0.03)
    assert np.percentile(ranges, [5, 95]) == pytest.approx([low, high], rel=0.05)


def test_frames_of_the_real_board_are_averaged(fresh):
    alone, together = fresh(1), fresh(1)
    frames = [board_range(0.1, alone, 0) for _ in range(10)]
    assert mean_board_range(0.1, together, 0, 10) == pytest.approx(np.mean(frames))


class Block:
    """Worlds of robots at given places, and their radio."""

    def __init__(self, places, n_worlds=1, **overrides):
        places = np.asarray(places, float)
        changes = {"n_robots": len(places), "start_radius": 0.3, **overrides}
        self.scenario = find_scenario("es1", changes)
        self.state = empty_state(n_worlds, len(places))
        self.state.pose[:] = np.tile(places, (n_worlds, 1))
        self.state.speaking[:] = True
        self.state.words[:, 0] = np.tile(1.0 + np.arange(len(places)), n_worlds)
        self.board = RadioBoard(self.scenario, len(self.state.pose))
        self.neighbours = Neighbours(self.scenario, n_worlds, self.board.reach)
        self.neighbours.find(self.state.pose)
        causes = (Cause.LOSS, Cause.SLOT, Cause.RADIO)
        seeds = range(n_worlds)
        self.streams = {cause: streams(seeds, len(places), cause) for cause in causes}

    def listen(self):
        return self.board(self.state, self.neighbours, self.streams)


@pytest.mark.parametrize("d", [0.005, 0.04, 0.08, 0.14])
def test_messages_are_lost_as_often_as_the_formula_says(d, believable):
    block = Block([(0, 0, 0), (d, 0, 0)], n_worlds=5000)
    heard = block.listen().valid.sum()
    expected = 1.0 - loss(d, 0.01, 0.15, 0.01, 0.5)
    believable(stats.binomtest(int(heard), 10_000, expected).pvalue)


def test_each_end_loses_for_itself(believable):
    heard = Block([(0, 0, 0), (0.149, 0, 0)], n_worlds=5000).listen().valid.any(axis=1)
    one, other = heard[0::2], heard[1::2]
    table = np.array([[np.sum(one & other), np.sum(one & ~other)],
                      [np.sum(~one & other), np.sum(~one & ~other)]])  # fmt: skip
    believable(stats.chi2_contingency(table).pvalue)


def test_nobody_beyond_the_range_is_heard():
    assert Block([(0, 0, 0), (0.15, 0, 0)], **QUIET).listen().valid.any()
    assert not Block([(0, 0, 0), (0.1501, 0, 0)], **QUIET).listen().valid.any()


def test_the_silent_are_not_heard():
    block = Block([(0, 0, 0), (0.1, 0, 0)], **QUIET)
    block.state.speaking[1] = False
    heard = block.listen()
    assert heard.valid.any(axis=1).tolist() == [False, True]
    assert block.state.messages.tolist() == [0, 1]


def test_a_message_carries_its_sender_and_words_and_no_other_world_hears_it():
    places = [(0, 0, 0), (0.1, 0, 0), (0.5, 0, 0)]
    heard = Block(places, n_worlds=2, **QUIET).listen()
    assert heard.valid.sum(axis=1).tolist() == [1, 1, 0, 1, 1, 0]
    assert heard.sender[:, 0].tolist() == [1, 0, 0, 1, 0, 0]
    assert heard.words[:, 0, 0].tolist() == [2, 1, 0, 2, 1, 0]


def test_the_beam_is_what_a_ruler_and_a_compass_say():
    # The sender stands 0.1 m to the north of a receiver that looks east, and looks north-west.
    heard = Block([(0, 0, 0), (0, 0.1, 0.75 * math.pi)], **QUIET).listen()
    north, back = math.pi / 2, wrap(-math.pi / 2 - 0.75 * math.pi)
    np.testing.assert_allclose(heard.beam[0, 0], [0.1, north, back], rtol=1e-6)
    np.testing.assert_allclose(heard.beam[1, 0], [0.1, back, north], rtol=1e-6)


def test_range_and_both_bearings_have_their_own_noise(believable):
    quiet = {"loss_near": 0.0, "loss_far": 0.0}
    block = Block([(0, 0, 0.3), (0.1, 0, -2.0)], n_worlds=3000, **quiet)
    block.state.wheels[:] = 0.06
    beam = block.listen().beam[0::2, 0].astype(float)
    errors = beam - [0.1, -0.3, wrap(math.pi + 2.0)]
    for error, most in zip(errors.T, (0.025, math.radians(20.0), math.radians(20.0)), strict=True):
        believable(stats.kstest(error, stats.uniform(-most, 2.0 * most).cdf).pvalue)
    correlations = np.corrcoef(errors.T)[np.triu_indices(3, 1)]
    assert np.abs(correlations).max() < 4.0 / math.sqrt(3000)


def test_a_receiver_at_rest_averages_its_frames_and_a_moving_one_does_not():
    block = Block([(0, 0, 0), (0.1, 0, 0)], n_worlds=2000, frames=10, loss_near=0.0, loss_far=0.0)
    block.state.wheels[1::2] = 0.06
    heard = block.listen()
    assert heard.frames[0::2, 0].tolist() == [10] * 2000
    assert heard.frames[1::2, 0].tolist() == [1] * 2000
    at_rest, moving = heard.beam[0::2, 0, 0].var(), heard.beam[1::2, 0, 0].var()
    assert moving / at_rest == pytest.approx(10.0, rel=0.15)


def test_a_bearing_stays_in_its_circle():
    heard = Block([(0.1, 0, 0), (0, 0, 0)], n_worlds=1000).listen()
    bearings = heard.beam[:, :, 1:].astype(float)
    assert bearings.min() >= -np.float32(np.pi)
    assert bearings.max() <= np.float32(np.pi)


def test_the_real_board_measures_between_the_rims():
    block = Block([(0, 0, 0), (0.12, 0, 0)], n_worlds=2000, frames=10, range_model="board")
    heard = block.listen()
    ranges = heard.beam[..., 0][heard.valid]
    assert ranges.min() > 0.07
    words = streams([1], 1, Cause.RADIO)
    alone = [mean_board_range(0.05, words, 0, 10) for _ in range(2000)]
    assert np.median(ranges) == pytest.approx(0.07 + np.median(alone), rel=0.02)


def test_of_more_messages_than_slots_each_is_heard_equally_often(believable):
    ring = [(0.1 * math.cos(a), 0.1 * math.sin(a), 0) for a in np.arange(7) * 2 * math.pi / 7]
    heard = Block([(0, 0, 0), *ring], n_worlds=4000, **QUIET).listen()
    receiver = heard.sender[0::8]
    assert heard.valid[0::8].all()
    assert receiver.shape[1] == 4
    assert all(len(set(senders)) == 4 for senders in receiver.tolist())
    counts = np.bincount(receiver.ravel(), minlength=8)
    assert counts[0] == 0
    # Four of seven without repeats vary less than independent draws: the factor is 1 - 3/6.
    chi2 = np.sum((counts[1:] - 4000 * 4 / 7) ** 2) / (4000 * 4 / 7)
    believable(stats.chi2(6).sf(chi2 / 0.5))


def test_more_than_one_message_is_heard_only_once_each():
    heard = Block([(0, 0, 0), (0.1, 0, 0), (-0.1, 0, 0)], **QUIET).listen()
    assert sorted(heard.sender[0].tolist()) == [1, 2]


def test_an_empty_slot_holds_zeros():
    block = Block([(0, 0, 0), (0.14, 0, 0), (0, 0.14, 0)], n_worlds=200)
    heard = block.listen()
    empty = ~heard.valid
    assert 0 < empty.sum() < empty.size
    for held in (heard.sender, heard.words, heard.beam, heard.frames):
        assert np.all(held[empty] == 0)
