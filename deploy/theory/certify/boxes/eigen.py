"""Small dense linear algebra in plain floating point: what it finds is a proposal, never a bound."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from deploy.theory.certify.boxes.kernel import compiled

Array = NDArray[np.float64]

_SWEEPS = 8
_HUGE = 1e100  # an inverse with such entries is of no use, and its products might overflow


@compiled
def lowest(matrix: Array, vector: Array) -> float:
    """Smallest eigenvalue of a symmetric matrix, which is overwritten, and its vector: Jacobi's rotations."""
    n = len(matrix)
    basis = np.zeros((n, n))
    for i in range(n):
        basis[i, i] = 1.0
    for _ in range(_SWEEPS):
        if _off_diagonal(matrix) < 1e-20:
            break
        for i in range(n):
            for j in range(i):
                _rotate(matrix, basis, i, j)
    best = 0
    for i in range(n):
        if matrix[i, i] < matrix[best, best]:
            best = i
    for i in range(n):
        vector[i] = basis[i, best]
    return float(matrix[best, best])


@compiled
def _off_diagonal(matrix: Array) -> float:
    total = 0.0
    for i in range(len(matrix)):
        for j in range(i):
            total += matrix[i, j] * matrix[i, j]
    return total


@compiled
def _rotate(matrix: Array, basis: Array, i: int, j: int) -> None:
    if matrix[i, j] == 0.0:
        return
    slope = (matrix[j, j] - matrix[i, i]) / (2.0 * matrix[i, j])
    t = 1.0 / (abs(slope) + np.sqrt(1.0 + slope * slope))
    if slope < 0.0:
        t = -t
    c = 1.0 / np.sqrt(1.0 + t * t)
    s = t * c
    for k in range(len(matrix)):
        one, two = matrix[k, i], matrix[k, j]
        matrix[k, i], matrix[k, j] = c * one - s * two, s * one + c * two
    for k in range(len(matrix)):
        one, two = matrix[i, k], matrix[j, k]
        matrix[i, k], matrix[j, k] = c * one - s * two, s * one + c * two
    for k in range(len(matrix)):
        one, two = basis[k, i], basis[k, j]
        basis[k, i], basis[k, j] = c * one - s * two, s * one + c * two


@compiled
def _pivot(matrix: Array, i: int) -> int:
    """Row of the largest entry of a column, from the diagonal down."""
    best = i
    for r in range(i + 1, len(matrix)):
        if abs(matrix[r, i]) > abs(matrix[best, i]):
            best = r
    return best


@compiled
def solve_into(matrix: Array, inverse: Array) -> bool:
    """The inverse by Gauss and Jordan; `matrix` is overwritten. False: singular, or as good as."""
    n = len(matrix)
    for i in range(n):
        for j in range(n):
            inverse[i, j] = 1.0 if i == j else 0.0
    for i in range(n):
        pivot = _pivot(matrix, i)
        if not abs(matrix[pivot, i]) > 1e-300:
            return False
        for c in range(n):
            matrix[i, c], matrix[pivot, c] = matrix[pivot, c], matrix[i, c]
            inverse[i, c], inverse[pivot, c] = inverse[pivot, c], inverse[i, c]
        scale = 1.0 / matrix[i, i]
        for c in range(n):
            matrix[i, c] *= scale
            inverse[i, c] *= scale
        for r in range(n):
            factor = matrix[r, i]
            if r != i and factor != 0.0:
                for c in range(n):
                    matrix[r, c] -= factor * matrix[i, c]
                    inverse[r, c] -= factor * inverse[i, c]
    return _tame(inverse)


@compiled
def _tame(matrix: Array) -> bool:
    """Whether every entry is a number of moderate size."""
    found = True
    for row in matrix:
        for entry in row:
            found = found and abs(entry) < _HUGE
    return found
