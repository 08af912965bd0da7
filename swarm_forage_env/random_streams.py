"""Random streams: one for each world, robot and source of noise, all from the seed of the world.

A world in a block draws the same values as alone; draws of one source do not affect another.
"""

from collections.abc import Sequence
from enum import IntEnum
from hashlib import blake2b

import numpy as np

from swarm_forage_env.arrays import Array, Float64, Int64, UInt64
from swarm_forage_env.compiler import entry_point
from swarm_forage_env.equations import pcg64, random_draws
from swarm_forage_env.equations.random_draws import Streams
from swarm_forage_env.errors import ConfigError, shown


class NoiseSource(IntEnum):
    """Source of noise of a stream. Its value enters the seed: add members, but change none."""

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
    POLICY = 13
    POLICY_BESIDE = 14
    WANDER = 64


seed_streams = entry_point(random_draws.seed_streams)


def streams(seeds: Sequence[int], n_robots: int, source: NoiseSource) -> UInt64[Array, " rows"]:
    """Return new streams of one source: a word for each row, `n_robots` rows for each seed."""
    return seed_streams(np.asarray(seeds, dtype=np.uint64), n_robots, int(source))


@entry_point
def draw_rows(streams: Streams, out: Float64[Array, "robots numbers"], is_normal: bool) -> None:
    """Fill the row of each robot from its stream: standard normal, or uniform in [0, 1)."""
    for i in range(out.shape[0]):
        for k in range(out.shape[1]):
            if is_normal:
                out[i, k] = random_draws.normal(streams, i)
            else:
                out[i, k] = random_draws.unit(streams, i)


def hash_of(name: str) -> np.uint64:
    """Return 64 bits of a name, equal in every process, to separate streams of one source."""
    return np.uint64(int.from_bytes(blake2b(name.encode(), digest_size=8).digest(), "little"))


def checked_seed(seed: object) -> int:
    """Return the seed as a whole number from 0 to 2^64 - 1; ConfigError for anything else."""
    if isinstance(seed, int | np.integer) and not isinstance(seed, bool):
        number = int(seed)
        if 0 <= number < 2**64:
            return number
    raise ConfigError(f"seed={shown(seed)}: must be a whole number from 0 to 2^64 - 1")


@entry_point
def start_seed_streams(
    seeds: UInt64[Array, " chosen"],
    chosen: Int64[Array, " chosen"],
    streams: UInt64[Array, "worlds 4"],
) -> None:
    """Start the streams from which these worlds draw the seeds of their episodes."""
    for k in range(chosen.shape[0]):
        pcg64.start_stream(seeds[k], streams[chosen[k]])


@entry_point
def draw_seeds(
    chosen: Int64[Array, " chosen"],
    streams: UInt64[Array, "worlds 4"],
    out: UInt64[Array, " chosen"],
) -> None:
    """Draw the seeds of the next episodes of these worlds, as `drawn_seed` does."""
    for k in range(chosen.shape[0]):
        out[k] = pcg64.draw_seed(streams[chosen[k]])


def generator_of(seed: int, stream: UInt64[Array, "4"]) -> np.random.Generator:
    """Return NumPy's generator of a seed, in the current state of a stream of seeds."""
    bits = np.random.PCG64(seed)
    s_high, s_low, c_high, c_low = map(int, stream)
    at = bits.state
    at["state"] = {"state": s_high << 64 | s_low, "inc": c_high << 64 | c_low}
    bits.state = at
    return np.random.Generator(bits)


def drawn_seed(rng: np.random.Generator) -> int:
    """Draw the seed of an episode for which none was given."""
    return int(rng.integers(2**63))
