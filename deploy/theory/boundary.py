"""The limit of grad phi on the boundary of free space (Lemma E.4, Propositions C.1 and C.2)."""

from __future__ import annotations

import numpy as np

from deploy.theory.function import (
    Array,
    Problem,
    gamma,
    obstacle_functions,
    weighted_obstacle_gradient,
)


def boundary_gradient(problem: Problem, b: Array) -> Array:
    """grad phi where at least one obstacle function is exactly zero, (p, 2) 1/m.

    Lemma E.4: -(1 / (k gamma^k)) grad beta. Its printed second form, a sum of beta_ij grad beta_ij, lacks
    a bar: the factor of grad beta_ij is the product of all the *other* obstacle functions (as printed the
    touching pair would be the one that drops out, and finite differences of phi disagree in direction).
    Hence it is non-zero with one contact (Proposition C.1), zero with two or more (Proposition C.2).
    """
    values = obstacle_functions(problem, b)
    weights = np.zeros_like(values)
    touching = np.flatnonzero(values == 0.0)
    if len(touching) == 1:
        others = np.log(np.delete(values, touching[0])).sum()
        weights[touching[0]] = np.exp(others - problem.k * np.log(gamma(problem, b))) / problem.k
    pairs = np.zeros((problem.p, problem.p))
    pairs[np.triu_indices(problem.p, 1)] = weights[problem.p :]
    return -weighted_obstacle_gradient(b, pairs + pairs.T, weights[: problem.p])
