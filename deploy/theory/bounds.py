"""Lower bounds on k: K1 (C.5, E.16), K2 (C.4, E.15), K3 (C.3), N1 and N2 (D.2).

Each is a maximum over configurations. What is returned is a proven upper bound of it, built from
gamma <= sum (|g_i| + |b_i|)^2 and the stretch of a cluster; K1 comes with a lower end as well.

Bounds are for one eps, or for the eps that proves most: the one with the smallest K.

Two formulas of the report do not do what they claim, and are replaced:

K22 = max (sigma2 + sigma3) gamma / sigma1: sigma1 depends on k, and k > K21 only makes it positive, not
bounded away from zero, so the maximum is infinite. The proof of Lemma E.15 gives
sigma1 >= A (1 - K21/k), A = rho' / (2|Pz| - 2) times the margin of Assumption 1; then
k > K21 + (sigma2 + sigma3) gamma / A suffices, and K2 here is that sum.

N2 = max -v^T A v / |H^T v|^2 over F1(eps) equals max gamma lambda_max(L1 L1^T - L0 L0^T), which is infinite
since beta_ij may vanish. It cannot be saved: k > N2 would make every critical point in F1(eps) a minimum,
against Proposition C.4. Non-degeneracy is therefore not proven by this route. Convergence from almost
every start does not need it: by C.4 every other critical point has a direction of negative curvature,
and the set attracted by such strict saddles has measure zero, degenerate or not.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

import numpy as np
from scipy.optimize import minimize_scalar

from deploy.theory.assumptions import Family, Margins, family, largest_eps, margins, smallest_contact
from deploy.theory.function import Array, Problem, obstacle_functions


@dataclass(frozen=True)
class Interval:
    """The true maximum over configurations lies in [low, high]."""

    low: float
    high: float


@dataclass(frozen=True)
class Bounds:
    """At this eps (m^2): phi is polar for k > K. `n2` is infinite, see the module."""

    eps: float
    k1: Interval
    k21: float
    k22: float
    k3: float
    n1: int
    n2: float = float("inf")

    @property
    def k2(self) -> float:
        """K21 plus the corrected K22."""
        return self.k21 + self.k22

    @property
    def polar(self) -> float:
        """K = max(K1, K2, K3), Proposition 3.1: above it the goal is the only minimum."""
        return max(self.k1.high, self.k2, self.k3)


def largest_gamma(problem: Problem, eps: float) -> float:
    """Upper bound of gamma where every beta_0i >= eps, m^2; eps = 0 for all of free space."""
    reach = np.sqrt(np.maximum(problem.reach**2 - eps, 0.0))
    return float(((np.linalg.norm(problem.goals, axis=1) + reach) ** 2).sum())


def _pair_reach(problem: Problem, eps: float) -> Array:
    """sqrt(rho_ij^2 + eps), (p, p) m, zero on the diagonal."""
    lengths = np.sqrt(problem.contact**2 + eps)
    np.fill_diagonal(lengths, 0.0)
    return np.asarray(lengths)


def _outer_reach(problem: Problem, clusters: Family, eps: float) -> Array:
    """Sum over Q* of sqrt(rho_ij^2 + eps), (S,) m; over all of Q for rows that stand for several clusters."""
    lengths = _pair_reach(problem, eps)
    total = 0.5 * lengths.sum()
    if clusters.members is None:
        return np.where(clusters.sizes == problem.p, 0.0, total)
    inside = clusters.members.astype(np.float64)
    own = 0.5 * np.einsum("si,ij,sj->s", inside, lengths, inside, optimize=True)
    return np.asarray(np.where(clusters.sizes == problem.p, 0.0, total - own))


def k1(problem: Problem, eps: float) -> Interval:
    """Proposition C.5. The lower end is attained at the goals turned by half a turn, where they lie in F2."""
    slopes = 0.5 * np.sqrt(2.0) * _pair_reach(problem, eps).sum()
    slopes += np.sqrt(np.maximum(problem.reach**2 - eps, 0.0)).sum()
    away = bool((obstacle_functions(problem, problem.goals) > eps).all())
    turned = 2.0 * np.linalg.norm(problem.goals) if away else 0.0
    return Interval(float(turned * slopes / eps), float(np.sqrt(largest_gamma(problem, eps)) * slopes / eps))


def k21(problem: Problem, found: Margins, eps: float) -> float:
    """Proposition C.4, Lemma E.15: above it sigma1 is positive at critical points in F1(eps)."""
    n = found.clusters.sizes
    several = n >= 2
    push = (n - 1) * (problem.workspace * n + _outer_reach(problem, found.clusters, eps))
    each = largest_gamma(problem, eps) * push[several] / (found.first[several] * eps)
    return float(each.max(initial=0.0))


def k22(problem: Problem, found: Margins, eps: float) -> float:
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


def k3(problem: Problem, found: Margins, eps: float) -> float:
    """Proposition C.3: above it no critical point lies within eps of the outer boundary."""
    pull = _outer_reach(problem, found.clusters, eps)
    return float((largest_gamma(problem, 0.0) * pull / (found.second * eps)).max())


def bounds(problem: Problem, eps: float, clusters: Family | None = None) -> Bounds | None:
    """All bounds at one eps (m^2); None where Assumptions 1 and 2 are not shown at this eps."""
    found = margins(problem, eps, clusters)
    if not found.hold:
        return None
    q = problem.p * (problem.p - 1) // 2
    return Bounds(
        eps,
        k1(problem, eps),
        k21(problem, found, eps),
        k22(problem, found, eps),
        k3(problem, found, eps),
        problem.p + q,
    )


def best_bounds(problem: Problem) -> Bounds | None:
    """Bounds at the best eps; None when the assumptions fail for every eps.

    K falls like 1/eps^2 for small eps and grows without limit where a margin vanishes.
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
