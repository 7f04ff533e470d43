"""Assumptions 1 and 2 on the goals (section 2.3), over all clusters.

Both are sufficient, and by the paper's own word very conservative: its simulations never check them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from deploy.theory.function import Array, Problem
from deploy.theory.gain.chains import Stretch, chain, first_objective, heavy_middle, smallest_contact, stretch
from deploy.theory.gain.families import Family, family

Status = Literal["holds", "violated", "not shown"]


@dataclass(frozen=True)
class Margins:
    """Left-hand side minus right-hand side for each cluster, m; an assumption holds where it is positive.

    first: Assumption 1, sum of |g_ij| - Lambda'. second: Assumption 2. sides: sqrt(rho''^2 - eps) minus the
    longest distance in the cluster; the proof of Proposition C.3 replaces the weights 1 + alpha_0n by 1,
    which needs every single term |b_z'| - delta_nz' to be non-negative, not only their sum.
    Assumption 1 starts at two robots; Proposition C.3 also needs Assumption 2 for single ones.
    """

    clusters: Family
    stretch: Stretch
    first: Array
    second: Array
    sides: Array

    @property
    def hold(self) -> bool:
        """Whether everything the proofs of Propositions C.3 and C.4 need is shown."""
        margins = (self.first, self.second, self.sides)
        return bool(all((margin > 0.0).all() for margin in margins))


def margins(problem: Problem, eps: float, clusters: Family | None = None) -> Margins:
    """Evaluate both assumptions for every cluster at eps (m^2), 0 <= eps < rho''^2."""
    rows = family(problem) if clusters is None else clusters
    lengths = stretch(problem, rows, eps)
    first = np.where(rows.sizes >= 2, rows.spread - lengths.first, np.inf)
    rim = np.sqrt(max(float(problem.reach.min()) ** 2 - eps, 0.0))
    second = rows.sizes * rim - lengths.second - rows.norms
    return Margins(rows, lengths, first, second, rim - lengths.longest)


def largest_eps(problem: Problem, clusters: Family | None = None) -> float | None:
    """Supremum of the eps at which both assumptions are shown, m^2; None when there is none.

    All margins fall as eps grows, so when they fail at eps = 0 they fail everywhere.
    """
    rows = family(problem) if clusters is None else clusters
    if not margins(problem, 0.0, rows).hold:
        return None
    low, high = 0.0, float(problem.reach.min()) ** 2
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if margins(problem, middle, rows).hold else (low, middle)
    return low


def first_status(problem: Problem, found: Margins, row: int, eps: float) -> Status:
    """Assumption 1 for one cluster; "not shown" when only the upper bound of Lambda' exceeds the spread."""
    if found.first[row] > 0.0:
        return "holds"
    members = found.clusters.names(row)
    if members is None:
        return "not shown"
    line = chain(heavy_middle(problem.radii[list(members)]), eps)
    attained = first_objective(line, smallest_contact(problem))
    fits = float(np.ptp(line[:, 0])) <= 2.0 * float(problem.reach.min())
    return "violated" if fits and attained >= found.clusters.spread[row] else "not shown"


def second_status(found: Margins, row: int) -> Status:
    """Assumption 2 for one cluster; a bounded Lambda'' leaves it open."""
    if found.second[row] > 0.0:
        return "holds"
    return "violated" if found.stretch.exact[row] else "not shown"
