"""Wheel encoders: the path of a wheel, misread a little."""

import numpy as np
import pytest
from scipy import stats

from swarm_forage_env.equations.differential_drive import encoder

ERROR = 0.00024


@pytest.mark.parametrize("path", [0.006, -0.006, 0.0129, 0.0])
def test_an_exact_encoder_tells_the_path(path, fresh):
    assert encoder(path, 0.0, fresh(1), 0) == path


def test_a_wheel_at_rest_is_read_exactly_and_draws_nothing(fresh):
    streams = fresh(1)
    before = streams.copy()
    assert encoder(0.0, ERROR, streams, 0) == 0.0
    assert streams == before


@pytest.mark.parametrize("path", [0.006, 0.002, -0.0001, 0.0129])
def test_the_error_is_uniform_whatever_the_path(path, fresh, believable):
    streams = fresh(1)
    missed = np.array([encoder(path, ERROR, streams, 0) for _ in range(8000)]) - path
    assert np.abs(missed).max() <= ERROR * (1.0 + 1e-9)
    believable(stats.kstest(missed, stats.uniform(-ERROR, 2.0 * ERROR).cdf).pvalue)
