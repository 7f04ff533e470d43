"""Equilibria of the flow, found numerically: damped Newton on D = 0 from many starts.

What is found is real (the residual is checked); that nothing was missed is not claimed.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import combinations

import numpy as np

from deploy.theory.critical import CriticalPoint, classify
from deploy.theory.function import Array, Problem, reduced_gradient
from deploy.theory.hessian import reduced_jacobian


def find_equilibrium(problem: Problem, start: Array, steps: int = 200) -> Array | None:
    """An interior zero of D near `start` (p, 2), by Levenberg-Marquardt; None when none is reached.

    Steps that leave free space or do not reduce |D| are shortened, so the boundary is never crossed.
    """
    b, reduced = start, reduced_gradient(problem, start)
    unit, damping = float(problem.radii.min()), 1e-3
    for _ in range(steps):
        size = float(np.abs(reduced).max())
        if not np.isfinite(size) or damping > 1e12:
            return None
        if size < 1e-10 * unit:
            return b
        jacobian = reduced_jacobian(problem, b)
        normal = jacobian.T @ jacobian
        scale = damping * np.diag(np.maximum(np.diag(normal), 1e-12))
        step = np.linalg.solve(normal + scale, -jacobian.T @ reduced.ravel()).reshape(b.shape)
        trial = reduced_gradient(problem, b + step)
        if np.linalg.norm(trial) < np.linalg.norm(reduced):  # false for nan
            b, reduced, damping = b + step, trial, max(damping / 5.0, 1e-15)
        elif np.abs(step).max() < 1e-14 * unit and size < 1e-7 * unit:
            return b  # rounding in the stiff layer
        else:
            damping *= 4.0
    return None


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
