"""Clusters of closest neighbours (section 2.3, appendix B) and the direction in which a cluster circles."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from deploy.theory.function import Array, FleetProblem, beta_pairs


def neighbours(problem: FleetProblem, b: Array, eps: float) -> NDArray[np.bool_]:
    """N_eps(b, i) as rows of a (p, p) matrix: 0 < beta_ij <= eps, eps in m^2."""
    beta = beta_pairs(problem, b)
    return np.asarray((beta > 0.0) & (beta <= eps))


def clusters(problem: FleetProblem, b: Array, eps: float) -> tuple[tuple[int, ...], ...]:
    """The partition P_1..P_s of robot indices (from 0), sorted, ordered by smallest member (Lemma B.3)."""
    near = neighbours(problem, b, eps)
    left, cells = set(range(problem.p)), []
    while left:
        cell: set[int] = set()
        ring = {min(left)}
        while ring:  # the (n+1)st neighbours: near to an nth neighbour, to none before
            cell |= ring
            ring = {int(j) for i in ring for j in np.flatnonzero(near[i])} - cell
        cells.append(tuple(sorted(cell)))
        left -= cell
    return tuple(cells)


def circulation(b: Array, cluster: tuple[int, ...]) -> Array:
    """v_z = sum over the cluster of J (b_n - g_z) (x) e_n, equation (15), (p, 2) m.

    All members circle their centroid g_z, the others stand still: the direction of negative curvature of
    Proposition C.4, hence a natural way off a saddle. J = [[0, 1], [-1, 0]].
    """
    members = list(cluster)
    arms = b[members] - b[members].mean(axis=0)
    v = np.zeros_like(b)
    v[members] = np.stack([arms[:, 1], -arms[:, 0]], axis=1)
    return v
