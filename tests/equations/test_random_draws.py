"""Chance: the published generator, its distributions, and streams that know nothing of others."""

import numpy as np
import pytest

from swarm_forage_env.equations.random_draws import (
    GOLDEN,
    below,
    exponential,
    first_word,
    mix,
    normal,
    symmetric,
    unit,
)
from swarm_forage_env.errors import ConfigError
from swarm_forage_env.random_streams import NoiseSource, checked_seed, streams

# SplitMix64 from seed 0: prng.di.unimi.it/splitmix64.c, and JDK's SplittableRandom(0).
PUBLISHED = (
    0xE220A8397B1DCDAF,
    0x6E789E6AA1B965F4,
    0x06C45D188009454F,
    0xF88BB8A8724C81EC,
    0x1B39896A51A8749B,
)


def drawn(draw, stream, n, *arguments):
    return np.array([draw(stream, 0, *arguments) for _ in range(n)])


def test_the_generator_gives_the_published_outputs_and_a_unit_draw_their_high_53_bits():
    states = [(k * int(GOLDEN)) % 2**64 for k in range(1, 6)]
    assert tuple(int(mix(np.uint64(state))) for state in states) == PUBLISHED
    stream = np.zeros(1, np.uint64)
    expected = [(output >> 11) * 2.0**-53 for output in PUBLISHED]
    assert drawn(unit, stream, 5).tolist() == expected


@pytest.mark.parametrize(
    ("seed", "robot", "cause", "word"),
    [
        (0, 0, 0, 0x215158DB81B8A2D3),
        (0, 1, 0, 0x5C7BDAF383FAD3DB),
        (0, 0, 1, 0xC75F70B6D0641946),
        (2**64 - 1, 9, 5, 0xBB3476B1C4C45FED),
        (7, 3, 2, 0xA37BA4466887C54E),
    ],
)
def test_streams_start_where_they_have_always_started(seed, robot, cause, word):
    # Worked out in whole numbers of Python; another start is another world under every seed.
    assert int(first_word(np.uint64(seed), robot, cause)) == word


def test_each_robot_of_each_world_has_the_stream_of_its_seed_and_number():
    expected = [first_word(np.uint64(seed), robot, 4) for seed in (3, 5) for robot in range(3)]
    assert streams([3, 5], 3, NoiseSource(4)).tolist() == [int(each) for each in expected]


def test_draws_of_every_shape_are_made_of_unit_draws(fresh):
    """By hand: the inverse of the distribution, and Box and Muller's formula."""
    streams, same = fresh(2), fresh(2)
    u, v, w, x, y = (unit(same, 1) for _ in range(5))
    assert symmetric(streams, 1) == 2.0 * u - 1.0
    assert below(streams, 1, 1000) == int(1000 * v)
    assert exponential(streams, 1, 3.0) == pytest.approx(-3.0 * np.log(1.0 - w))
    expected = np.sqrt(-2.0 * np.log(1.0 - x)) * np.cos(2.0 * np.pi * y)
    assert normal(streams, 1) == pytest.approx(expected)
    assert streams.tolist() == same.tolist()


def test_the_largest_unit_draw_stays_below_n():
    # The state before the one that mix sends to all ones: the worst case of rounding.
    stream = np.array([inverse_mix(2**64 - 1) - int(GOLDEN)], dtype=np.uint64)
    assert unit(stream.copy(), 0) == 1.0 - 2.0**-53
    assert below(stream, 0, 3) == 2


def inverse_mix(z):
    """The word that `mix` scrambles into z: its steps undone, last first."""
    for shift, factor in ((31, 0x94D049BB133111EB), (27, 0xBF58476D1CE4E5B9), (30, 1)):
        word = z
        for _ in range(64 // shift + 1):
            word = z ^ (word >> shift)
        z = (word * pow(factor, -1, 2**64)) % 2**64
    return z


def test_no_two_streams_meet_within_ten_million_draws():
    words = np.concatenate([streams(range(60), 60, source) for source in NoiseSource])
    inverse = np.uint64(pow(int(GOLDEN), -1, 2**64))
    places = np.sort(words * inverse)  # all streams walk the same circle, one step to a draw
    assert np.diff(places).min() > 10_000_000


@pytest.mark.parametrize("seed", [0, 1, 2**64 - 1, np.int64(5), np.uint64(2**63)])
def test_a_seed_is_a_whole_number_of_64_bits(seed):
    assert checked_seed(seed) == int(seed)
    assert len(streams([checked_seed(seed)], 3, NoiseSource.PLACE)) == 3


@pytest.mark.parametrize("seed", [-1, 2**64, 0.5, "0", None, True, float("nan")])
def test_any_other_seed_is_refused_by_name(seed):
    with pytest.raises(ConfigError, match=r"seed=.*whole number from 0 to 2"):
        checked_seed(seed)
