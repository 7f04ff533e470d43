"""Equilibria of the flow, found numerically: nonlinear least squares on D = 0 from many starts.

What is found is real (the residual is checked); that nothing was missed is not claimed.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import combinations

import numpy as np
from scipy.optimize import least_squares

from deploy.theory.critical import CriticalPoint, classify
from deploy.theory.function import Array, Problem, reduced_gradient
from deploy.theory.hessian import reduced_jacobian

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
