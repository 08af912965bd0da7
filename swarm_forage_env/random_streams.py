"""Random streams: one for each world, robot and source of noise, all from the seed of the world.

Two controllers under one seed meet the same world; a world in a block draws what it
draws alone; and drawing more for one cause does not move another.
"""

from collections.abc import Sequence
from enum import IntEnum
from hashlib import blake2b

import numpy as np

from swarm_forage_env.arrays import Array, UInt64
from swarm_forage_env.compiler import entry_point
from swarm_forage_env.equations import random_draws
from swarm_forage_env.errors import ConfigError, shown


class NoiseSource(IntEnum):
    """The source of noise that a stream is for.

    The number enters the stream's seed: never change one, only add.
    """

    PLACE = 0
    ENCODER = 1
    PROXIMITY = 2
    GROUND = 3
    LOSS = 4
    SLOT = 5
    RADIO = 6
    GOAL = 7
    LANDMARK = 8
    LIDAR = 9
    DEVICE = 10
    SCENARIO = 11
    FAULT = 12
    WANDER = 64


seed_streams = entry_point(random_draws.seed_streams)


def streams(seeds: Sequence[int], n_robots: int, source: NoiseSource) -> UInt64[Array, " rows"]:
    """Fresh streams of one source: a word for each row, `n_robots` rows for each seed."""
    return seed_streams(np.asarray(seeds, dtype=np.uint64), n_robots, int(source))


def hash_of(name: str) -> np.uint64:
    """64 bits of a name, the same in every process: for several streams of one source."""
    return np.uint64(int.from_bytes(blake2b(name.encode(), digest_size=8).digest(), "little"))


def checked_seed(seed: object) -> int:
    """The seed as a whole number from 0 to 2^64 - 1; ConfigError for anything else."""
    if isinstance(seed, int | np.integer) and not isinstance(seed, bool):
        number = int(seed)
        if 0 <= number < 2**64:
            return number
    raise ConfigError(f"seed={shown(seed)}: must be a whole number from 0 to 2^64 - 1")


def drawn_seed(rng: np.random.Generator) -> int:
    """The seed of an episode for which none was given: the next of a sequence."""
    return int(rng.integers(2**63))


LAST_64 = 2**64 - 1


def words_of(rng: np.random.Generator) -> UInt64[Array, "6"]:
    """Where a generator of `numpy.random.default_rng` stands, in six words."""
    state = rng.bit_generator.state
    numbers = state["state"]["state"], state["state"]["inc"]
    halves = [number >> shift & LAST_64 for number in numbers for shift in (64, 0)]
    return np.array([*halves, state["has_uint32"], state["uinteger"]], np.uint64)


def generator_at(words: UInt64[Array, "6"]) -> np.random.Generator:
    """The generator that stands where `words_of` was told.

    >>> rng = generator_at(words_of(np.random.default_rng(1)))
    >>> drawn_seed(rng) == drawn_seed(np.random.default_rng(1))
    True
    """
    high, low, inc_high, inc_low, has_half, half = map(int, words)
    rng = np.random.default_rng()
    rng.bit_generator.state = {
        "bit_generator": "PCG64",
        "state": {"state": high << 64 | low, "inc": inc_high << 64 | inc_low},
        "has_uint32": has_half,
        "uinteger": half,
    }
    return rng
