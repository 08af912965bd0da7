"""Algebra of 3 x 3 matrices for kernels, written out.

Functions write to `out`, where there is one; it must be none of the inputs.
"""

import math

from swarm_forage_env.arrays import Array, Float64
from swarm_forage_env.compiler import kernel
from swarm_forage_env.equations.elementary import acos, cos

Matrix3 = Float64[Array, "3 3"]

TINY = 1e-100  # least spread of eigenvalues: the cube of a smaller one underflows


@kernel
def identity3(scale: float, out: Matrix3) -> None:
    """Write the identity matrix times `scale`."""
    for a in range(3):
        for b in range(3):
            out[a, b] = scale if a == b else 0.0


@kernel
def transpose3(A: Matrix3, out: Matrix3) -> None:
    """Write the transpose A'."""
    for a in range(3):
        for b in range(3):
            out[a, b] = A[b, a]


@kernel
def product3(A: Matrix3, B: Matrix3, out: Matrix3) -> None:
    """Write the product A B."""
    for a in range(3):
        for b in range(3):
            out[a, b] = A[a, 0] * B[0, b] + A[a, 1] * B[1, b] + A[a, 2] * B[2, b]


@kernel
def product3_transposed(A: Matrix3, B: Matrix3, out: Matrix3) -> None:
    """Write the product A B'."""
    for a in range(3):
        for b in range(3):
            out[a, b] = A[a, 0] * B[b, 0] + A[a, 1] * B[b, 1] + A[a, 2] * B[b, 2]


@kernel
def symmetrise3(P: Matrix3) -> None:
    """Symmetrise P = (P + P') / 2, in place."""
    for a in range(3):
        for b in range(a):
            P[a, b] = P[b, a] = 0.5 * (P[a, b] + P[b, a])


@kernel
def determinant3(A: Matrix3) -> float:
    """Return det A."""
    return float(
        A[0, 0] * (A[1, 1] * A[2, 2] - A[1, 2] * A[2, 1])
        - A[0, 1] * (A[1, 0] * A[2, 2] - A[1, 2] * A[2, 0])
        + A[0, 2] * (A[1, 0] * A[2, 1] - A[1, 1] * A[2, 0])
    )


@kernel
def inverse3(A: Matrix3, out: Matrix3) -> None:
    """Write the inverse of A by its adjugate; not finite if A is singular."""
    scale = 1.0 / determinant3(A)
    for a in range(3):
        a1, a2 = (a + 1) % 3, (a + 2) % 3
        for b in range(3):
            b1, b2 = (b + 1) % 3, (b + 2) % 3
            out[b, a] = scale * (A[a1, b1] * A[a2, b2] - A[a1, b2] * A[a2, b1])


@kernel
def spectral_norm3(P: Matrix3) -> float:
    """Return the largest absolute eigenvalue of a symmetric matrix.

    The three eigenvalues are q + 2 r cos(phi + 2 k pi / 3).

    Source: Smith1961 (Eigenvalues of a symmetric 3 x 3 matrix, CACM 4:168).
    """
    off = P[0, 1] ** 2 + P[0, 2] ** 2 + P[1, 2] ** 2
    q = (P[0, 0] + P[1, 1] + P[2, 2]) / 3.0
    d0, d1, d2 = P[0, 0] - q, P[1, 1] - q, P[2, 2] - q
    r = math.sqrt((d0 * d0 + d1 * d1 + d2 * d2 + 2.0 * off) / 6.0)
    if r < TINY:
        return float(abs(q))
    half = (
        d0 * (d1 * d2 - P[1, 2] ** 2)
        - P[0, 1] * (P[0, 1] * d2 - P[1, 2] * P[0, 2])
        + P[0, 2] * (P[0, 1] * P[1, 2] - d1 * P[0, 2])
    ) / (2.0 * r**3)
    phi = acos(min(max(half, -1.0), 1.0)) / 3.0
    high = q + 2.0 * r * cos(phi)
    low = q + 2.0 * r * cos(phi + 2.0 * math.pi / 3.0)
    return float(max(abs(high), abs(low)))


@kernel
def cholesky3(P: Matrix3, out: Matrix3) -> None:
    """Write the lower triangle L with L L' = P of a positive definite matrix."""
    for a in range(3):
        for b in range(3):
            out[a, b] = 0.0
    for a in range(3):
        for b in range(a + 1):
            rest = P[a, b]
            for k in range(b):
                rest -= out[a, k] * out[b, k]
            out[a, b] = math.sqrt(rest) if a == b else rest / out[b, b]


@kernel
def solve_lower3(L: Matrix3, B: Matrix3, out: Matrix3) -> None:
    """Write L^-1 B for a lower triangle L."""
    for b in range(3):
        for a in range(3):
            rest = B[a, b]
            for k in range(a):
                rest -= L[a, k] * out[k, b]
            out[a, b] = rest / L[a, a]
