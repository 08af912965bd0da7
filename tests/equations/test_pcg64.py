"""The sequence of seeds that kernels draw is that of NumPy's generator."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from swarm_forage_env.random_streams import draw_seeds, generator_of, start_seed_streams

SEEDS = st.integers(0, 2**64 - 1) | st.sampled_from([0, 1, 2**32 - 1, 2**32, 2**64 - 1])


@given(SEEDS, st.integers(0, 5))
def test_seeds_are_those_that_numpy_draws(seed, n_before):
    usual, chosen = np.random.default_rng(seed), np.array([1])
    streams, drawn = np.zeros((2, 4), np.uint64), np.zeros(1, np.uint64)
    start_seed_streams(np.array([seed], np.uint64), chosen, streams)
    for _ in range(n_before):
        draw_seeds(chosen, streams, drawn)
        assert drawn[0] == usual.integers(2**63)
    again = generator_of(seed, streams[1])
    assert again.bit_generator.state == usual.bit_generator.state
    assert again.integers(2**63) == usual.integers(2**63)
    assert not streams[0].any()
