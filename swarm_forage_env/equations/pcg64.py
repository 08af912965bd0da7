"""Stream of the episode seeds of a world: NumPy's default generator, for CPU and GPU.

A stream is the state of `numpy.random.default_rng(seed)`, a permuted congruential generator: state
s and increment c of 128 bits each, as words (s high, s low, c high, c low). NumPy's `SeedSequence`
hashes the seed to the first state.

Source: ONeill2014, PCG: A Family of Simple Fast Space-Efficient Statistically Good Algorithms for
Random Number Generation; O'Neill 2015, Developing a seed_seq Alternative (the hash).
"""

import numpy as np

from swarm_forage_env.arrays import Array, UInt64
from swarm_forage_env.compiler import kernel

Stream = UInt64[Array, "4"]

_LOW = np.uint64(0xFFFFFFFF)
_ONE, _S16, _S32, _S58, _S63 = map(np.uint64, (1, 16, 32, 58, 63))
_START_A, _FACTOR_A = np.uint64(0x43B0D7E5), np.uint64(0x931E8875)
_START_B, _FACTOR_B = np.uint64(0x8B51F9DD), np.uint64(0x58F38DED)
_MIX_LEFT, _MIX_RIGHT = np.uint64(0xCA01F9DD), np.uint64(0x4973F715)
_FACTOR_HIGH, _FACTOR_LOW = np.uint64(0x2360ED051FC65DA4), np.uint64(0x4385DF649FCCF645)
_64 = np.uint64(64)


@kernel
def start_stream(seed: np.uint64, out: Stream) -> None:
    """Write the state of `default_rng(seed)` to `out`."""
    constant = _START_A
    for k in range(4):
        word = seed & _LOW if k == 0 else seed >> _S32 if k == 1 else seed ^ seed
        out[k], constant = _hashed(word, constant, _FACTOR_A)
    for source in range(4):
        for k in range(4):
            if k != source:
                word, constant = _hashed(out[source], constant, _FACTOR_A)
                out[k] = _mixed(out[k], word)
    s_high, constant = _joined(out[0], out[1], _START_B)
    s_low, constant = _joined(out[2], out[3], constant)
    c_high, constant = _joined(out[0], out[1], constant)
    c_low, constant = _joined(out[2], out[3], constant)
    out[2], out[3] = c_high << _ONE | c_low >> _S63, c_low << _ONE | _ONE
    out[0], out[1] = _sum(out[2], out[3], s_high, s_low)
    _advance(out)


@kernel
def draw_seed(stream: Stream) -> np.uint64:
    """Draw the next `integers(2**63)` of the generator: its next 64 bits without the last.

        s' = s a + c,    x = rotate(s' high ^ s' low, s' >> 122)

    Source: ONeill2014, PCG-XSL-RR-128/64.
    """
    _advance(stream)
    word, turns = stream[0] ^ stream[1], stream[0] >> _S58
    left = (_64 - turns) & (_64 - _ONE)
    return np.uint64((word >> turns | word << left) >> _ONE)


@kernel
def _advance(stream: Stream) -> None:
    high, low = _product(stream[0], stream[1], _FACTOR_HIGH, _FACTOR_LOW)
    stream[0], stream[1] = _sum(high, low, stream[2], stream[3])


@kernel
def _sum(
    a_high: np.uint64, a_low: np.uint64, b_high: np.uint64, b_low: np.uint64
) -> tuple[np.uint64, np.uint64]:
    low = a_low + b_low
    carry = _ONE if low < a_low else _ONE ^ _ONE
    return a_high + b_high + carry, low


@kernel
def _product(
    a_high: np.uint64, a_low: np.uint64, b_high: np.uint64, b_low: np.uint64
) -> tuple[np.uint64, np.uint64]:
    a_0, a_1, b_0, b_1 = a_low & _LOW, a_low >> _S32, b_low & _LOW, b_low >> _S32
    middle = a_1 * b_0 + (a_0 * b_0 >> _S32)
    other = a_0 * b_1 + (middle & _LOW)
    high = a_1 * b_1 + (middle >> _S32) + (other >> _S32)
    return high + a_high * b_low + a_low * b_high, a_low * b_low


@kernel
def _hashed(word: np.uint64, constant: np.uint64, factor: np.uint64) -> tuple[np.uint64, np.uint64]:
    """Scramble a 32-bit word by a constant; returns it and the next constant."""
    following = constant * factor & _LOW
    scrambled = (word ^ constant) * following & _LOW
    return scrambled ^ scrambled >> _S16, following


@kernel
def _joined(
    first: np.uint64, second: np.uint64, constant: np.uint64
) -> tuple[np.uint64, np.uint64]:
    """Return 64 bits of the hash from two of its words, and the next constant."""
    low, constant = _hashed(first, constant, _FACTOR_B)
    high, constant = _hashed(second, constant, _FACTOR_B)
    return high << _S32 | low, constant


@kernel
def _mixed(a: np.uint64, b: np.uint64) -> np.uint64:
    """Mix two 32-bit words into one."""
    both = a * _MIX_LEFT - b * _MIX_RIGHT & _LOW
    return both ^ both >> _S16
