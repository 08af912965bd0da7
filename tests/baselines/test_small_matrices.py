"""Small matrices inside kernels, against numpy."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_allclose, assert_array_equal

from baselines.estimators.small_matrices import (
    cholesky3,
    copy3,
    determinant3,
    identity3,
    inverse3,
    product3,
    product3_transposed,
    solve_lower3,
    spectral_norm3,
    symmetrise3,
    transpose3,
)

ENTRIES = st.floats(-3.0, 3.0).map(lambda x: round(x, 6))
MATRICES = arrays(np.float64, (3, 3), elements=ENTRIES)
SYMMETRIC = MATRICES.map(lambda each: each + each.T)
POSITIVE = MATRICES.map(lambda each: each @ each.T + 0.1 * np.eye(3))


def filled(helper, *given_):
    """What a helper writes into an array that held other numbers."""
    out = np.full((3, 3), 7.0)
    helper(*given_, out)
    return out


@given(MATRICES, MATRICES)
def test_products_copies_and_transposes_are_those_of_numpy(A, B):  # noqa: N803 matrices
    assert_allclose(filled(product3, A, B), A @ B, atol=1e-12)
    assert_allclose(filled(product3_transposed, A, B), A @ B.T, atol=1e-12)
    assert_array_equal(filled(copy3, A), A)
    assert_array_equal(filled(transpose3, A), A.T)
    assert_array_equal(filled(identity3, A[0, 0]), A[0, 0] * np.eye(3))


@given(MATRICES)
def test_a_symmetrised_matrix_is_the_mean_of_itself_and_its_transpose(A):  # noqa: N803
    found = A.copy()
    symmetrise3(found)
    assert_array_equal(found, found.T)
    assert_allclose(found, (A + A.T) / 2.0, atol=1e-15)


@given(MATRICES)
def test_the_determinant_is_that_of_numpy(A):  # noqa: N803
    assert determinant3(A) == pytest.approx(np.linalg.det(A), abs=1e-11)


@given(MATRICES)
def test_the_inverse_of_any_matrix_that_has_one_undoes_it(A):  # noqa: N803
    assume(abs(np.linalg.det(A)) > 1e-2)
    assert_allclose(filled(inverse3, A) @ A, np.eye(3), atol=1e-8)


def test_a_matrix_without_an_inverse_has_no_finite_one():
    assert not np.isfinite(filled(inverse3, np.ones((3, 3)))).any()


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


@given(POSITIVE)
def test_the_lower_triangle_is_that_of_numpy(P):  # noqa: N803
    found = filled(cholesky3, P)
    assert_allclose(found, np.linalg.cholesky(P), atol=1e-9)
    assert_array_equal(found, np.tril(found))


@given(POSITIVE, MATRICES)
def test_solving_by_a_lower_triangle_is_multiplying_with_its_inverse(P, B):  # noqa: N803
    L = np.ascontiguousarray(np.linalg.cholesky(P))  # noqa: N806 as in the kernel
    assert_allclose(filled(solve_lower3, L, B), np.linalg.solve(L, B), rtol=1e-9, atol=1e-9)
