"""Small dense linear algebra, NumPy's: what it finds is a proposal, never a bound."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from deploy.theory.certify.boxes.kernel import compiled

Array = NDArray[np.float64]

_HUGE = 1e100  # an inverse with such entries is of no use, and its products might overflow


@compiled
def lowest(matrix: Array, vector: Array) -> float:
    """Smallest eigenvalue of a symmetric matrix, and its vector; +inf where an entry is not finite."""
    if not np.isfinite(matrix).all():
        return np.inf
    values, vectors = np.linalg.eigh(matrix)
    vector[:] = vectors[:, 0]
    return float(values[0])


@compiled
def solve_into(matrix: Array, inverse: Array) -> bool:
    """The inverse. False: singular, or as good as."""
    if not np.isfinite(matrix).all():
        return False
    try:
        inverse[:] = np.linalg.inv(matrix)
    except Exception:  # noqa: BLE001  compiled code tells no more of it
        return False
    return bool((np.abs(inverse) < _HUGE).all())
