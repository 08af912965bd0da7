"""Small matrices inside kernels, against numpy."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from baselines.estimators.small_matrices import (
    inverse3,
    spectral_norm3,
)

ENTRIES = st.floats(-3.0, 3.0).map(lambda x: round(x, 6))
SYMMETRIC = arrays(np.float64, (3, 3), elements=ENTRIES).map(lambda each: each + each.T)


def test_a_matrix_without_an_inverse_has_no_finite_one():
    out = np.full((3, 3), 7.0)
    inverse3(np.ones((3, 3)), out)
    assert not np.isfinite(out).any()


@given(SYMMETRIC)
def test_the_spectral_norm_is_the_largest_absolute_eigenvalue(P):  # noqa: N803
    largest = np.abs(np.linalg.eigvalsh(P)).max()
    assert spectral_norm3(P) == pytest.approx(largest, rel=1e-7, abs=1e-9)


@pytest.mark.parametrize(
    ("diagonal", "norm"),
    [((0, 0, 0), 0), ((0.1, 0.1, 0.1), 0.1), ((1, 1, 3), 3), ((1, 3, 3), 3), ((-5, 0, 4), 5)],
)
def test_the_spectral_norm_of_a_diagonal_is_its_largest_number(diagonal, norm):
    assert spectral_norm3(np.diag(np.array(diagonal, float))) == pytest.approx(norm, rel=1e-8)
