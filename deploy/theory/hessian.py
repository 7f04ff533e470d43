"""Second derivatives: the Jacobian of D, and of the obstacle functions what it is made of.

Matrices are (2p, 2p) with robot-major order: row 2i + a is axis a of robot i.
"""

from __future__ import annotations

import numpy as np

from deploy.theory.function import (
    Array,
    Problem,
    beta_boundary,
    beta_pairs,
    displacements,
    gamma,
    weighted_obstacle_gradient,
)


def _laplacian(weights: Array) -> Array:
    """Sum over pairs i < j of w_ij (e_i - e_j)(e_i - e_j)^T for blocks w_ij, (p, p, ...) -> same shape."""
    index = np.arange(len(weights))
    out = -weights
    out[index, index] += weights.sum(axis=1)
    return np.asarray(out)


def _flat(blocks: Array) -> Array:
    """(p, p, 2, 2) blocks to (2p, 2p)."""
    p = len(blocks)
    return np.asarray(blocks.transpose(0, 2, 1, 3).reshape(2 * p, 2 * p))


def obstacle_curvature(problem: Problem, b: Array) -> Array:
    """Sum over Q0 of D^2 beta_ij / beta_ij = 2 (L1 L1^T - L0 L0^T), Lemma E.10, (2p, 2p) 1/m^2."""
    scalar = _laplacian(1.0 / beta_pairs(problem, b)) - np.diag(1.0 / beta_boundary(problem, b))
    return np.asarray(2.0 * np.kron(scalar, np.eye(2)))


def obstacle_outer(problem: Problem, b: Array) -> Array:
    """Sum over Q0 of grad beta_ij grad beta_ij^T / beta_ij^2 = 4 L M M^T L^T, Lemma E.11, (2p, 2p) 1/m^2."""
    unit = displacements(b) / beta_pairs(problem, b)[:, :, None]
    blocks = _laplacian(unit[..., :, None] * unit[..., None, :])
    own = b / beta_boundary(problem, b)[:, None]
    index = np.arange(problem.p)
    blocks[index, index] += own[:, :, None] * own[:, None, :]
    return 4.0 * _flat(blocks)


def reduced_jacobian(problem: Problem, b: Array) -> Array:
    """dD/db = 2 I - (1/k) grad log beta grad gamma^T - (gamma/k) D^2 log beta, (2p, 2p).

    Not symmetric in general; symmetric, and 1/c times the Hessian of phi, at critical points.
    """
    steer = weighted_obstacle_gradient(
        b, 1.0 / beta_pairs(problem, b), 1.0 / beta_boundary(problem, b)
    ).ravel()
    curvature = obstacle_curvature(problem, b) - obstacle_outer(problem, b)
    pull = 2.0 * (b - problem.goals).ravel()
    out = -(np.outer(steer, pull) + gamma(problem, b) * curvature) / problem.k
    out[np.diag_indices_from(out)] += 2.0
    return np.asarray(out)
