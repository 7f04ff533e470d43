"""Lambda' and Lambda'', equations (7) and (8): how far a cluster can stretch.

In a cluster, neighbours i, j are at most a_ij = sqrt(rho_ij^2 + eps) apart, and by Minkowski
a_ij <= s_i + s_j with s_i = sqrt(rho_i^2 + eps/4), with equality for equal radii. So two members h hops
apart are at most U_h apart, where U_h is s_i + s_j + 2 (h - 1 others), largest members counted, and of
course never more than the workspace allows. Removing a leaf of a spanning tree shows that a cluster of n
has at most (n - h)(n - h + 1) / 2 pairs that are h or more hops apart, and that at most n - h members are
so far from a given one. As ||v||^2 = (1/n) sum of delta_ij^2, both objectives increase with every
distance, so replacing the pairs h hops apart by U_h bounds both. A straight chain attains every one of
these inequalities when the radii are equal and it fits into the workspace: then the value is exact.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from deploy.theory.function import Array, Problem
from deploy.theory.gain.families import Family


@dataclass(frozen=True)
class Stretch:
    """Lambda' and Lambda'' of each cluster of a family, and the largest ||v||^2 and distance.

    All (S,); lengths in m, `circulation` in m^2. `exact` tells where the values are attained by a straight
    chain (given room for the other robots beside it); elsewhere they are proven upper bounds.
    """

    first: Array
    second: Array
    circulation: Array
    longest: Array
    exact: NDArray[np.bool_]


def _hops(clusters: Family, workspace: float, eps: float) -> tuple[Array, NDArray[np.bool_]]:
    """U_h in column h - 1, (S, p - 1), zero beyond the cluster; and whether the workspace clips none."""
    half = np.nan_to_num(np.sqrt(clusters.radii**2 + eps / 4.0))
    reach = half.cumsum(axis=1)
    hops = reach[:, 1:].copy()  # h - 1 largest twice, the next two once: the sums of h + 1 and of h - 1
    hops[:, 1:] += reach[:, :-2]
    smallest = np.sort(clusters.radii, axis=1)[:, :2]
    room = 2.0 * workspace - np.nansum(smallest, axis=1)
    inside = np.arange(1, clusters.radii.shape[1]) < clusters.sizes[:, None]
    clipped = np.where(inside, np.minimum(hops, room[:, None]), 0.0)
    return clipped, np.asarray((~inside | (hops <= room[:, None])).all(axis=1))


def stretch(problem: Problem, clusters: Family, eps: float) -> Stretch:
    """Lambda' (7), Lambda'' (8) for every cluster of the family at eps (m^2)."""
    hops, unclipped = _hops(clusters, problem.workspace, eps)
    n = clusters.sizes.astype(np.float64)
    pairs = np.maximum(n[:, None] - np.arange(1, problem.p), 0.0)  # a chain has n - h pairs h hops apart
    turning = (pairs * hops**2).sum(axis=1) / n
    sides = (pairs * hops).sum(axis=1)
    spacing = smallest_contact(problem)
    first = sides + (2.0 * n - 2.0) / spacing * turning
    equal = np.nanmax(clusters.radii, axis=1) == np.nanmin(clusters.radii, axis=1)
    exact = equal & unclipped & clusters.enumerated
    return Stretch(first, hops.sum(axis=1), turning, hops.max(axis=1, initial=0.0), exact)


def smallest_contact(problem: Problem) -> float:
    """rho' = min over Q of rho_ij, over all robots, m; a lone robot's diameter, which nothing uses."""
    return float(np.sort(problem.radii)[:2].sum()) if problem.p > 1 else 2.0 * float(problem.radii[0])


def chain(radii: Array, eps: float) -> Array:
    """Centres of a straight chain of these disks in this order, beta = eps between neighbours, (n, 2) m."""
    gaps = np.sqrt((radii[:-1] + radii[1:]) ** 2 + eps)
    along = np.concatenate([[0.0], np.cumsum(gaps)])
    return np.stack([along - along.mean(), np.zeros_like(along)], axis=1)


def first_objective(points: Array, spacing: float) -> float:
    """What (7) maximises, at one cluster's centres (n, 2): sum of delta_ij + (2n - 2)/rho' ||v||^2, m."""
    n = len(points)
    distances = np.linalg.norm(points[:, None] - points[None], axis=2)
    return float(distances.sum() / 2.0 + (2 * n - 2) / spacing * ((points - points.mean(axis=0)) ** 2).sum())


def heavy_middle(radii: Array) -> Array:
    """The same radii ordered for a long chain: smallest at the ends, largest in the middle."""
    ordered = np.sort(radii)
    return np.concatenate([ordered[::2], ordered[1::2][::-1]])
