"""Random draws inside kernels: one 64-bit stream per robot and cause.

The state of a stream is one word, which each draw advances. A robot has one stream (a column of
`Streams`) for each cause. Draws of one robot for one cause change no draws of other robots or
causes.

Source: Steele2014, SplitMix64 (Fast splittable pseudorandom number generators, OOPSLA).
"""

import math

import numpy as np

from swarm_forage_env.arrays import Array, UInt64
from swarm_forage_env.compiler import kernel
from swarm_forage_env.equations.elementary import cos, log

Streams = UInt64[Array, " columns"]
"""Words of the streams of a robot, one column per cause; or of one cause, one per robot."""

GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_MIX_1 = np.uint64(0xBF58476D1CE4E5B9)
_MIX_2 = np.uint64(0x94D049BB133111EB)
_ROBOT = np.uint64(0xD1342543DE82EF95)
_CAUSE = np.uint64(0x2545F4914F6CDD1D)
_S30, _S27, _S31, _S11 = np.uint64(30), np.uint64(27), np.uint64(31), np.uint64(11)


@kernel
def mix(z: np.uint64) -> np.uint64:
    """Scramble 64 bits by a bijection.

    Source: Steele2014, mix64, variant 13 of the MurmurHash3 finaliser.
    """
    z = (z ^ (z >> _S30)) * _MIX_1
    z = (z ^ (z >> _S27)) * _MIX_2
    return z ^ (z >> _S31)


@kernel
def unit(streams: Streams, column: int) -> float:
    """Draw uniformly from [0, 1), with 53 bits, from the stream of a column.

    Source: Steele2014, nextDouble.
    """
    word = streams[column]
    streams[column] = word + GOLDEN
    return unit_of(word)


@kernel
def unit_of(word: np.uint64) -> float:
    """Return the first uniform draw in [0, 1) of a stream that starts at this word."""
    return float(mix(word + GOLDEN) >> _S11) * 2.0**-53


@kernel
def symmetric(streams: Streams, column: int) -> float:
    """Draw uniformly from [-1, 1), from the stream of a column."""
    return 2.0 * unit(streams, column) - 1.0


@kernel
def below(streams: Streams, column: int, n: int) -> int:
    """Draw an integer uniformly from 0 .. n - 1, from the stream of a column."""
    return int(unit(streams, column) * n)


@kernel
def exponential(streams: Streams, column: int, mean: float) -> float:
    """Draw from the exponential distribution with this mean, by inversion."""
    return -mean * log(1.0 - unit(streams, column))


@kernel
def normal(streams: Streams, column: int) -> float:
    """Draw from the standard normal distribution.

        z = sqrt(-2 ln u) cos(2 pi v)

    Source: BoxMuller1958.
    """
    u, v = 1.0 - unit(streams, column), unit(streams, column)
    return math.sqrt(-2.0 * log(u)) * cos(2.0 * math.pi * v)


@kernel
def first_word(seed: np.uint64, robot: int, cause: int) -> np.uint64:
    """Return the first word of a stream: a hash of the seed of the world, robot and cause."""
    word = mix(seed + GOLDEN)
    word = mix(word + np.uint64(robot + 1) * _ROBOT)
    return mix(word + np.uint64(cause + 1) * _CAUSE)


@kernel
def seed_streams(
    worlds: UInt64[Array, " worlds"], n_robots: int, cause: int
) -> UInt64[Array, " rows"]:
    """Return new streams of one cause; robot r of world w starts at a hash of (seed, r, cause)."""
    streams = np.empty(worlds.shape[0] * n_robots, np.uint64)
    for w in range(worlds.shape[0]):
        for r in range(n_robots):
            streams[w * n_robots + r] = first_word(worlds[w], r, cause)
    return streams
