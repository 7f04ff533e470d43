"""Assumptions 1 and 2 on the goals (section 2.3), over all clusters of robots, and the bounds on k from them.

Both assumptions are sufficient and, by the paper's own word, very conservative: its simulations do not check
them. Up to 12 robots every cluster is evaluated, beyond that one bounding row per cluster size.

Stretch of a cluster, Lambda' and Lambda'' of equations (7) and (8): In a cluster, neighbours i, j are at most
a_ij = sqrt(rho_ij^2 + eps) apart, and by Minkowski a_ij <= s_i + s_j with s_i = sqrt(rho_i^2 + eps/4), with
equality for equal radii. So two members h hops apart are at most U_h apart, where U_h is s_i + s_j + 2 (h - 1
others), with the largest members, and at most what the workspace allows. Removing a leaf of a spanning tree
shows that a cluster of n has at most (n - h)(n - h + 1) / 2 pairs that are h or more hops apart, and that at
most n - h members are that far from a given one. As ||v||^2 = (1/n) sum of delta_ij^2, both objectives
increase with every distance, so replacing the pairs h hops apart by U_h bounds both. A straight chain attains
all these inequalities when the radii are equal and it fits into the workspace: then the value is exact.

The bounds are K1 (C.5, E.16), K2 (C.4, E.15), K3 (C.3), N1 and N2 (D.2), each a maximum over configurations.
The results are proven upper bounds of these, from gamma <= sum (|g_i| + |b_i|)^2 and the stretch of clusters;
K1 also has a lower end. They are for one eps, or for the eps with the smallest K.

Two formulas of the report do not do what they claim, and are replaced:

K22 = max (sigma2 + sigma3) gamma / sigma1: sigma1 depends on k, and k > K21 only makes it positive, not
bounded away from zero, so the maximum is infinite. The proof of Lemma E.15 gives sigma1 >= A (1 - K21/k), A =
rho' / (2|Pz| - 2) times the margin of Assumption 1; then k > K21 + (sigma2 + sigma3) gamma / A suffices, and
K2 here is that sum.

N2 = max -v^T A v / |H^T v|^2 over F1(eps) equals max gamma lambda_max(L1 L1^T - L0 L0^T), which is infinite
since beta_ij may vanish. It cannot be saved: k > N2 would make every critical point in F1(eps) a minimum,
against Proposition C.4. So non-degeneracy is not proven by this route. Convergence from almost every start
does not need it: by C.4 every other critical point has a direction of negative curvature, and the set
attracted by such strict saddles has measure zero, degenerate or not.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from deploy.theory.function import FleetProblem, displacements, obstacle_functions
from protocol.arrays import Reals

LARGEST_ENUMERATION = 12


@dataclass(frozen=True)
class Family:
    """S clusters. If not `enumerated`, row n - 1 bounds all clusters of n robots."""

    sizes: NDArray[np.int64]
    radii: Reals  # (S, p) m, members first, largest first, nan for the rest
    spread: Reals  # (S,) m, sum of |g_ij| over the pairs; a lower bound for bounding rows
    norms: Reals  # (S,) m, sum of |g_i|; an upper bound for bounding rows
    members: NDArray[np.bool_] | None  # (S, p), None for bounding rows

    @property
    def enumerated(self) -> bool:
        """Whether each row is one cluster."""
        return self.members is not None

    def names(self, row: int) -> tuple[int, ...] | None:
        """Robot indices of one cluster, None for a bounding row."""
        return None if self.members is None else tuple(int(i) for i in np.flatnonzero(self.members[row]))


def family(problem: FleetProblem) -> Family:
    """All non-empty subsets of up to 12 robots, or one bounding row per size."""
    return _every(problem) if problem.p <= LARGEST_ENUMERATION else _bounds(problem)


def _goal_distances(problem: FleetProblem) -> Reals:
    return np.asarray(np.linalg.norm(displacements(problem.goals), axis=2))


def _every(problem: FleetProblem) -> Family:
    codes = np.arange(1, 2**problem.p)
    members = (codes[:, None] >> np.arange(problem.p)) & 1 == 1
    radii = -np.sort(np.where(members, -problem.radii, np.nan), axis=1)  # nan sorts last
    inside = members.astype(np.float64)
    spread = 0.5 * np.einsum("si,ij,sj->s", inside, _goal_distances(problem), inside, optimize=True)
    norms = inside @ np.linalg.norm(problem.goals, axis=1)
    return Family(members.sum(axis=1), radii, spread, norms, members)


def _bounds(problem: FleetProblem) -> Family:
    """For n robots: the n largest radii and |g_i|, and the n smallest sums of n - 1 nearest distances."""
    p = problem.p
    sizes = np.arange(1, p + 1)
    largest = np.sort(problem.radii)[::-1]
    radii = np.where(np.arange(p) < sizes[:, None], largest, np.nan)
    nearest = np.sort(_goal_distances(problem), axis=1).cumsum(axis=1)  # [i, n-1]: to the n - 1 nearest
    spread = 0.5 * np.sort(nearest, axis=0).cumsum(axis=0)[sizes - 1, sizes - 1]
    norms = np.sort(np.linalg.norm(problem.goals, axis=1))[::-1].cumsum()
    return Family(sizes, radii, spread, norms, None)


@dataclass(frozen=True)
class Stretch:
    """Bounds of each cluster of a family, all (S,), proven from above."""

    first: Reals  # Lambda', m
    second: Reals  # Lambda'', m
    circulation: Reals  # the largest ||v||^2, m^2
    longest: Reals  # the largest distance, m
    exact: NDArray[np.bool_]  # attained by a straight chain, with room for the other robots beside it


def _hops(clusters: Family, workspace: float, eps: float) -> tuple[Reals, NDArray[np.bool_]]:
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


def stretch(problem: FleetProblem, clusters: Family, eps: float) -> Stretch:
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


def smallest_contact(problem: FleetProblem) -> float:
    """rho' = min over Q of rho_ij, over all robots, m; for one robot its diameter, which is not used."""
    return float(np.sort(problem.radii)[:2].sum()) if problem.p > 1 else 2.0 * float(problem.radii[0])


def chain(radii: Reals, eps: float) -> Reals:
    """Centres of a straight chain of these disks in this order, beta = eps between neighbours, (n, 2) m."""
    gaps = np.sqrt((radii[:-1] + radii[1:]) ** 2 + eps)
    along = np.concatenate([[0.0], np.cumsum(gaps)])
    return np.stack([along - along.mean(), np.zeros_like(along)], axis=1)


def first_objective(points: Reals, spacing: float) -> float:
    """Objective of (7) at one cluster's centres (n, 2): sum of delta_ij + (2n - 2)/rho' ||v||^2, m."""
    n = len(points)
    distances = np.linalg.norm(points[:, None] - points[None], axis=2)
    return float(distances.sum() / 2.0 + (2 * n - 2) / spacing * ((points - points.mean(axis=0)) ** 2).sum())


def heavy_middle(radii: Reals) -> Reals:
    """The radii ordered for a long chain: smallest at the ends, largest in the middle."""
    ordered = np.sort(radii)
    return np.concatenate([ordered[::2], ordered[1::2][::-1]])


ConditionStatus = Literal["holds", "violated", "not shown"]


@dataclass(frozen=True)
class Margins:
    """Left-hand side minus right-hand side for each cluster, m; an assumption holds if it is positive.

    first: Assumption 1, sum of |g_ij| - Lambda'. second: Assumption 2. sides: sqrt(rho''^2 - eps) minus the
    longest distance in the cluster; the proof of Proposition C.3 replaces the weights 1 + alpha_0n by 1,
    which needs every single term |b_z'| - delta_nz' to be non-negative, not only their sum. Assumption 1
    concerns two or more robots; Proposition C.3 also needs Assumption 2 for single ones.
    """

    clusters: Family
    stretch: Stretch
    first: Reals
    second: Reals
    sides: Reals

    @property
    def hold(self) -> bool:
        """Whether all that the proofs of Propositions C.3 and C.4 need is shown."""
        margins = (self.first, self.second, self.sides)
        return bool(all((margin > 0.0).all() for margin in margins))


def margins(problem: FleetProblem, eps: float, clusters: Family | None = None) -> Margins:
    """Evaluate both assumptions for every cluster at eps (m^2), 0 <= eps < rho''^2."""
    rows = family(problem) if clusters is None else clusters
    lengths = stretch(problem, rows, eps)
    first = np.where(rows.sizes >= 2, rows.spread - lengths.first, np.inf)
    rim = np.sqrt(max(float(problem.reach.min()) ** 2 - eps, 0.0))
    second = rows.sizes * rim - lengths.second - rows.norms
    return Margins(rows, lengths, first, second, rim - lengths.longest)


def largest_eps(problem: FleetProblem, clusters: Family | None = None) -> float | None:
    """Supremum of the eps at which both assumptions are shown, m^2; None if there is none.

    All margins decrease as eps grows, so if they fail at eps = 0 they fail everywhere.
    """
    rows = family(problem) if clusters is None else clusters
    if not margins(problem, 0.0, rows).hold:
        return None
    low, high = 0.0, float(problem.reach.min()) ** 2
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if margins(problem, middle, rows).hold else (low, middle)
    return low


def first_status(problem: FleetProblem, found: Margins, row: int, eps: float) -> ConditionStatus:
    """Assumption 1 for one cluster; "not shown" if only the upper bound of Lambda' exceeds the spread."""
    if found.first[row] > 0.0:
        return "holds"
    members = found.clusters.names(row)
    if members is None:
        return "not shown"
    line = chain(heavy_middle(problem.radii[list(members)]), eps)
    attained = first_objective(line, smallest_contact(problem))
    fits = float(np.ptp(line[:, 0])) <= 2.0 * float(problem.reach.min())
    return "violated" if fits and attained >= found.clusters.spread[row] else "not shown"


def second_status(found: Margins, row: int) -> ConditionStatus:
    """Assumption 2 for one cluster; "not shown" if only the upper bound of Lambda'' fails."""
    if found.second[row] > 0.0:
        return "holds"
    return "violated" if found.stretch.exact[row] else "not shown"


@dataclass(frozen=True)
class Enclosure:
    """Bounds of the true maximum over configurations."""

    low: float
    high: float


@dataclass(frozen=True)
class Bounds:
    """Bounds at this eps (m^2): phi is polar for k > K. `n2` is infinite, as the module explains."""

    eps: float
    k1: Enclosure
    k21: float
    k22: float
    k3: float
    n1: int
    n2: float
    k2: float  # K21 plus the corrected K22
    polar: float  # K = max(K1, K2, K3), Proposition 3.1: above it the goal is the only minimum


def largest_gamma(problem: FleetProblem, eps: float) -> float:
    """Upper bound of gamma where every beta_0i >= eps, m^2; eps = 0 for all of free space."""
    reach = np.sqrt(np.maximum(problem.reach**2 - eps, 0.0))
    return float(((np.linalg.norm(problem.goals, axis=1) + reach) ** 2).sum())


def _pair_reach(problem: FleetProblem, eps: float) -> Reals:
    lengths = np.sqrt(problem.contact**2 + eps)
    np.fill_diagonal(lengths, 0.0)
    return np.asarray(lengths)


def _outer_reach(problem: FleetProblem, clusters: Family, eps: float) -> Reals:
    """Sum over Q* of sqrt(rho_ij^2 + eps), (S,) m; over all of Q for bounding rows."""
    lengths = _pair_reach(problem, eps)
    total = 0.5 * lengths.sum()
    if clusters.members is None:
        return np.where(clusters.sizes == problem.p, 0.0, total)
    inside = clusters.members.astype(np.float64)
    own = 0.5 * np.einsum("si,ij,sj->s", inside, lengths, inside, optimize=True)
    return np.asarray(np.where(clusters.sizes == problem.p, 0.0, total - own))


def k1(problem: FleetProblem, eps: float) -> Enclosure:
    """Proposition C.5. The goals rotated by half a turn attain the lower end if they lie in F2."""
    slopes = 0.5 * np.sqrt(2.0) * _pair_reach(problem, eps).sum()
    slopes += np.sqrt(np.maximum(problem.reach**2 - eps, 0.0)).sum()
    apart = bool((obstacle_functions(problem, problem.goals) > eps).all())
    turned = 2.0 * np.linalg.norm(problem.goals) if apart else 0.0
    return Enclosure(float(turned * slopes / eps), float(np.sqrt(largest_gamma(problem, eps)) * slopes / eps))


def k21(problem: FleetProblem, found: Margins, eps: float) -> float:
    """Proposition C.4, Lemma E.15: above it sigma1 is positive at critical points in F1(eps)."""
    n = found.clusters.sizes
    several = n >= 2
    push = (n - 1) * (problem.workspace * n + _outer_reach(problem, found.clusters, eps))
    each = largest_gamma(problem, eps) * push[several] / (found.first[several] * eps)
    return float(each.max(initial=0.0))


def k22(problem: FleetProblem, found: Margins, eps: float) -> float:
    """(sigma2 + sigma3) gamma / A, the corrected second part of K2.

    With r_j = |b_j - g_z|: sigma2 <= sum r_j^2 (1/eps + 2 rho_ij^2/eps^2), as beta_ij > eps across clusters,
    and sigma3 <= sum r_j^2 (2 (rho_0j^2 - eps)/eps^2 + 1/eps), since b_j^T J g_z = b_j^T J (g_z - b_j).
    """
    n = found.clusters.sizes
    several = n >= 2
    pair = 1.0 / eps + 2.0 * problem.contact**2 / eps**2
    np.fill_diagonal(pair, 0.0)
    rim = 2.0 * np.maximum(problem.reach**2 - eps, 0.0) / eps**2 + 1.0 / eps
    members = np.ones((len(n), problem.p), bool) if found.clusters.members is None else found.clusters.members
    outside = np.ones_like(members) if found.clusters.members is None else ~members
    weight = np.where(members, outside @ pair + rim, 0.0).max(axis=1)
    sigma = found.stretch.circulation * weight
    lead = smallest_contact(problem) / (2.0 * np.maximum(n - 1, 1)) * found.first
    each = largest_gamma(problem, eps) * sigma[several] / lead[several]
    return float(each.max(initial=0.0))


def k3(problem: FleetProblem, found: Margins, eps: float) -> float:
    """Proposition C.3: above it no critical point lies within eps of the outer boundary."""
    pull = _outer_reach(problem, found.clusters, eps)
    return float((largest_gamma(problem, 0.0) * pull / (found.second * eps)).max())


def bounds(problem: FleetProblem, eps: float, clusters: Family | None = None) -> Bounds | None:
    """All bounds at one eps (m^2); None if Assumptions 1 and 2 are not shown there."""
    found = margins(problem, eps, clusters)
    if not found.hold:
        return None
    p, first, third = problem.p, k1(problem, eps), k3(problem, found, eps)
    turn, rest = k21(problem, found, eps), k22(problem, found, eps)
    polar = max(first.high, turn + rest, third)
    return Bounds(eps, first, turn, rest, third, p + p * (p - 1) // 2, inf, turn + rest, polar)


def best_bounds(problem: FleetProblem) -> Bounds | None:
    """Bounds at the best eps; None if the assumptions fail for every eps.

    K falls as 1/eps^2 for small eps, and grows without limit as a margin vanishes.
    """
    clusters = family(problem)
    limit = largest_eps(problem, clusters)
    if limit is None:
        return None

    def polar(eps: float) -> float:
        found = bounds(problem, eps, clusters)
        return inf if found is None else found.polar

    best = minimize_scalar(polar, bounds=(0.0, limit), method="bounded", options={"xatol": 1e-6 * limit})
    return bounds(problem, float(best.x), clusters)
