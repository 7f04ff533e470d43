"""Equilibria of the flow, found by nonlinear least squares on D = 0 and classified by the Hessian.

What is found is real (the residual is checked); that nothing was missed is not claimed.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import combinations
from typing import Literal

import numpy as np
from scipy.optimize import least_squares

from deploy.theory.function import Array, Problem, reduced_gradient, reduced_jacobian

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


_ROUNDING = 1e-15
_ZERO = 1e-7  # |D| in units of the smallest radius, above rounding in the stiff layer


def find_equilibrium(problem: Problem, start: Array, steps: int = 200) -> Array | None:
    """An interior zero of D near `start` (p, 2), by SciPy's trust region; None when none is reached.

    Steps that leave free space (D is nan there) are shortened, so the boundary is never crossed.
    """
    unit = float(problem.radii.min())
    if not np.isfinite(reduced_gradient(problem, start)).all():
        return None
    found = least_squares(
        lambda y: reduced_gradient(problem, unit * y.reshape(start.shape)).ravel() / unit,
        start.ravel() / unit,
        lambda y: reduced_jacobian(problem, unit * y.reshape(start.shape)),
        ftol=_ROUNDING,
        xtol=_ROUNDING,
        gtol=_ROUNDING,
        max_nfev=steps,
    )
    return unit * found.x.reshape(start.shape) if np.abs(found.fun).max() < _ZERO else None


def swapped_pairs(problem: Problem) -> list[Array]:
    """Starts close to the saddles in which two robots block each other and the others stand at their goals.

    The two stand on the line through their goals in reversed order, at the distance at which repulsion
    and attraction balance; only those in the interior of free space.
    """
    starts = []
    for i, j in combinations(range(problem.p), 2):
        apart = problem.goals[i] - problem.goals[j]
        far, contact = float(np.linalg.norm(apart)), float(problem.contact[i, j])
        beta = (far + contact) * contact / problem.k  # gamma / (k alpha), alpha = |b_i - g_i| / delta_ij
        half = -0.5 * np.sqrt(contact**2 + beta) * apart / far
        b = problem.goals.copy()
        b[i], b[j] = (middle := 0.5 * (b[i] + b[j])) + half, middle - half
        if np.isfinite(reduced_gradient(problem, b)).all():
            starts.append(b)
    return starts


def equilibria(problem: Problem, starts: Iterable[Array]) -> tuple[CriticalPoint, ...]:
    """Distinct equilibria reached from the starts, classified, the goal always first."""
    unit = float(problem.radii.min())
    found = [classify(problem, problem.goals)]
    for start in starts:
        b = find_equilibrium(problem, start)
        if b is not None and all(np.abs(b - known.b).max() > 1e-4 * unit for known in found):
            found.append(classify(problem, b))
    return tuple(found)
