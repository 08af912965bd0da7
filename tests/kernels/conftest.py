"""Fixtures of the kernels' tests."""

import numpy as np
import pytest

from swarm_forage_env.streams import Cause, streams

PASSES = 1e-4
"""Least p-value of a test of randomness. Seeds are fixed, so a pass stays a pass."""


@pytest.fixture
def fresh():
    """Fresh streams for so many rows, from a fixed seed."""

    def make(rows, seed=20090):
        return streams([seed], rows, Cause.ENCODER)

    return make


@pytest.fixture
def believable():
    """Assert that a p-value does not speak against the hypothesis."""

    def check(p_value):
        assert np.all(np.asarray(p_value) > PASSES), p_value

    return check
