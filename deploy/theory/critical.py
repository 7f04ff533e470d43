"""Classification of critical points by the signs of the Hessian's eigenvalues."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from deploy.theory.function import Array, Problem
from deploy.theory.hessian import reduced_jacobian

Kind = Literal["minimum", "saddle", "maximum", "degenerate"]


@dataclass(frozen=True)
class CriticalPoint:
    """An equilibrium of the flow. b: (p, 2) m; index: number of negative eigenvalues (its Morse index).

    spectrum: (2p,) eigenvalues of (1/c) D^2 phi, increasing, without unit: 2 is the curvature of gamma.
    """

    b: Array
    kind: Kind
    index: int
    spectrum: Array


def classify(problem: Problem, b: Array, tolerance: float = 1e-6) -> CriticalPoint:
    """Kind of a critical point `b` in the interior, where D^2 phi = c dD/db and c > 0 never matters.

    An eigenvalue counts as zero below `tolerance`, relative to 2, or below rounding of the largest one.
    """
    jacobian = reduced_jacobian(problem, b)
    spectrum: Array = np.asarray(np.linalg.eigvalsh(0.5 * (jacobian + jacobian.T)), dtype=np.float64)
    zero = 2.0 * tolerance + 1e-13 * float(np.abs(spectrum).max())
    index = int((spectrum < -zero).sum())
    return CriticalPoint(b, _kind(spectrum, index, zero), index, spectrum)


def _kind(spectrum: Array, index: int, zero: float) -> Kind:
    if (np.abs(spectrum) <= zero).any():
        return "degenerate"
    if index == 0:
        return "minimum"
    return "maximum" if index == len(spectrum) else "saddle"
