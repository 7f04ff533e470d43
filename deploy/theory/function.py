"""The navigation function phi, its reduced gradient D, and their derivatives.

Karagöz, Bozma, Koditschek, equations (1)-(5), (9). gamma^k and beta differ by hundreds of orders of magnitude
and exceed the range of a double, so neither is computed: D = grad phi / c needs only the derivatives of their
logarithms.

Outside free space phi is undefined and D is nan. A negative beta is never clamped, since that would hide a
collision.

Second derivatives are (2p, 2p) matrices in robot-major order: row 2i + a is axis a of robot i.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from protocol.arrays import Reals


@dataclass(frozen=True)
class FleetProblem:
    """p disks in one disk workspace around the origin."""

    goals: Reals  # (p, 2) m
    radii: Reals  # (p,) m, positive
    workspace: float  # radius rho_0, m
    k: float  # tuning parameter, positive

    @property
    def p(self) -> int:
        """Number of robots."""
        return len(self.radii)

    @property
    def reach(self) -> Reals:
        """Largest allowed distance of each centre from the origin, rho_0i = rho_0 - rho_i, (p,) m."""
        return self.workspace - self.radii

    @property
    def contact(self) -> Reals:
        """Contact distances rho_ij = rho_i + rho_j, (p, p) m."""
        return self.radii[:, None] + self.radii[None, :]


def gamma(problem: FleetProblem, b: Reals) -> float:
    """gamma = |b - g|^2, m^2."""
    return float(((b - problem.goals) ** 2).sum())


def displacements(b: Reals) -> Reals:
    """d_ij = b_i - b_j, (p, p, 2) m."""
    return b[:, None, :] - b[None, :, :]


def beta_pairs(problem: FleetProblem, b: Reals) -> Reals:
    """beta_ij = |b_i - b_j|^2 - rho_ij^2, (p, p) m^2, symmetric; +inf on the diagonal, so 1/beta_ii = 0."""
    beta = (displacements(b) ** 2).sum(axis=2) - problem.contact**2
    np.fill_diagonal(beta, np.inf)
    return np.asarray(beta)


def beta_boundary(problem: FleetProblem, b: Reals) -> Reals:
    """beta_0i = rho_0i^2 - |b_i|^2, (p,) m^2; negative for a disk larger than the workspace."""
    return np.asarray(problem.reach * np.abs(problem.reach) - (b**2).sum(axis=1))


def obstacle_functions(problem: FleetProblem, b: Reals) -> Reals:
    """All factors of beta, (p + q,) m^2: beta_01..beta_0p, then beta_ij for i < j row by row.

    None is negative in free space, equations (1)-(3).
    """
    pairs = beta_pairs(problem, b)[np.triu_indices(problem.p, 1)]
    return np.concatenate([beta_boundary(problem, b), pairs])


def weighted_obstacle_gradient(b: Reals, weights: Reals, boundary_weights: Reals) -> Reals:
    """Sum over pairs of w_ij grad beta_ij + w_0i grad beta_0i, (p, 2).

    weights: (p, p) symmetric, zero diagonal; boundary_weights: (p,). With weights 1/beta this is
    grad log beta.
    """
    pull = weights.sum(axis=1)[:, None] * b - weights @ b
    return np.asarray(2.0 * (pull - boundary_weights[:, None] * b))


def reduced_gradient(problem: FleetProblem, b: Reals) -> Reals:
    """D = grad gamma - (gamma / k) grad log beta, (p, 2) m; grad phi = c D with c > 0 common to all robots.

    Row i is robot i's slice D_i. Finite for any k and p in the interior of free space; nan on its
    boundary and outside.
    """
    pairs, boundary = beta_pairs(problem, b), beta_boundary(problem, b)
    if not ((pairs > 0.0).all() and (boundary > 0.0).all()):
        return np.full_like(b, np.nan)
    steer = weighted_obstacle_gradient(b, 1.0 / pairs, 1.0 / boundary)
    return np.asarray(2.0 * (b - problem.goals) - gamma(problem, b) / problem.k * steer)


def _laplacian(weights: Reals) -> Reals:
    """Sum over pairs i < j of w_ij (e_i - e_j)(e_i - e_j)^T for blocks w_ij, (p, p, ...) -> same shape."""
    index = np.arange(len(weights))
    out = -weights
    out[index, index] += weights.sum(axis=1)
    return np.asarray(out)


def obstacle_curvature(problem: FleetProblem, b: Reals) -> Reals:
    """Sum over Q0 of D^2 beta_ij / beta_ij = 2 (L1 L1^T - L0 L0^T), Lemma E.10, (2p, 2p) 1/m^2."""
    scalar = _laplacian(1.0 / beta_pairs(problem, b)) - np.diag(1.0 / beta_boundary(problem, b))
    return np.asarray(2.0 * np.kron(scalar, np.eye(2)))


def obstacle_outer(problem: FleetProblem, b: Reals) -> Reals:
    """Sum over Q0 of grad beta_ij grad beta_ij^T / beta_ij^2 = 4 L M M^T L^T, Lemma E.11, (2p, 2p) 1/m^2."""
    unit = displacements(b) / beta_pairs(problem, b)[:, :, None]
    blocks = _laplacian(unit[..., :, None] * unit[..., None, :])
    own = b / beta_boundary(problem, b)[:, None]
    index = np.arange(problem.p)
    blocks[index, index] += own[:, :, None] * own[:, None, :]
    return np.asarray(4.0 * blocks.transpose(0, 2, 1, 3).reshape(2 * problem.p, 2 * problem.p))


def reduced_jacobian(problem: FleetProblem, b: Reals) -> Reals:
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
