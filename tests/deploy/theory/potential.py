"""phi itself, its gradient, Hessian and limit on the boundary, and N2: what only the paper's identities need.

Evaluated in logarithms, as gamma^k and beta leave the range of a double. A negative beta gives nan.
"""

from __future__ import annotations

import numpy as np

from deploy.theory.function import (
    Array,
    FleetProblem,
    beta_boundary,
    beta_pairs,
    gamma,
    obstacle_curvature,
    obstacle_functions,
    reduced_gradient,
    reduced_jacobian,
    weighted_obstacle_gradient,
)


def _log(values: Array) -> Array:
    """Logarithm with log 0 = -inf, and nan for a negative value."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.log(values))


def log_beta(problem: FleetProblem, b: Array) -> float:
    """log beta, the sum over all pairs; -inf on the boundary of free space, nan outside it."""
    return float(_log(obstacle_functions(problem, b)).sum())


def _log_gamma_k(problem: FleetProblem, b: Array) -> float:
    """k log gamma; -inf at the goal."""
    return float(problem.k * _log(np.array(gamma(problem, b))))


def log_sum_exp(x: float, y: float) -> float:
    """log(e^x + e^y); nan as soon as one is nan, without a warning."""
    with np.errstate(invalid="ignore"):
        return float(np.logaddexp(x, y))


def log_ratio(problem: FleetProblem, b: Array) -> float:
    """log phi_hat = k log gamma - log beta, equation (5); -inf at the goal, +inf on the boundary."""
    return _log_gamma_k(problem, b) - log_beta(problem, b)


def phi(problem: FleetProblem, b: Array) -> float:
    """phi = (gamma^k / (gamma^k + beta))^(1/k), equation (9).

    Exactly 0 at the goal, exactly 1 on the boundary of free space, nan outside it.
    """
    return float(np.exp(-log_sum_exp(0.0, -log_ratio(problem, b)) / problem.k))


def log_scale(problem: FleetProblem, b: Array) -> float:
    """log c, where grad phi = c D: log beta - (1 + 1/k) log(gamma^k + beta)."""
    total = log_beta(problem, b)
    return total - (1.0 + 1.0 / problem.k) * log_sum_exp(_log_gamma_k(problem, b), total)


def gradient(problem: FleetProblem, b: Array) -> Array:
    """grad phi, (p, 2) 1/m, in the interior of free space and at its goal; nan elsewhere.

    Deep in the repulsive layer c underflows and the gradient is a true zero to double precision: use
    `reduced_gradient` for directions. The limit on the boundary is `boundary_gradient`.
    """
    return np.asarray(np.exp(log_scale(problem, b)) * reduced_gradient(problem, b))


def boundary_gradient(problem: FleetProblem, b: Array) -> Array:
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


def hessian(problem: FleetProblem, b: Array) -> Array:
    """D^2 phi = c (dD/db + D (grad log c)^T) in the interior of free space, (2p, 2p) 1/m^2.

    At the goal this is Proposition D.1, 2 beta(g)^(-1/k) I, which finite differences confirm.
    """
    scale = np.exp(log_scale(problem, b))
    if gamma(problem, b) == 0.0:
        return np.asarray(2.0 * scale * np.eye(2 * problem.p))
    steer = weighted_obstacle_gradient(
        b, 1.0 / beta_pairs(problem, b), 1.0 / beta_boundary(problem, b)
    ).ravel()
    share = 1.0 / (1.0 + np.exp(min(log_ratio(problem, b), 700.0)))  # beta / (gamma^k + beta)
    pull = 2.0 * (b - problem.goals).ravel() / gamma(problem, b)
    log_total = (1.0 - share) * problem.k * pull + share * steer
    slope = steer - (1.0 + 1.0 / problem.k) * log_total
    reduced = reduced_gradient(problem, b).ravel()
    return np.asarray(scale * (reduced_jacobian(problem, b) + np.outer(reduced, slope)))


def n2_at(problem: FleetProblem, b: Array) -> float:
    """gamma lambda_max(L1 L1^T - L0 L0^T) at one configuration: what N2 maximises; unbounded near contact."""
    return float(gamma(problem, b) * np.linalg.eigvalsh(obstacle_curvature(problem, b))[-1] / 2.0)
