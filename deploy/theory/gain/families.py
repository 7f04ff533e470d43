"""The clusters of Assumptions 1 and 2: every subset of up to 12 robots, beyond that one bound per size."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from deploy.theory.function import Array, Problem, displacements

LARGEST_ENUMERATION = 12


@dataclass(frozen=True)
class Family:
    """S clusters at once. With `enumerated` false, row n - 1 stands for all clusters of n robots.

    radii: (S, p) m, members first, largest first, nan for the rest; spread: (S,) m, sum of |g_ij| over the
    pairs (a lower bound for rows that stand for several); norms: (S,) m, sum of |g_i| (an upper bound for
    such rows); members: (S, p), None when rows stand for several.
    """

    sizes: NDArray[np.int64]
    radii: Array
    spread: Array
    norms: Array
    members: NDArray[np.bool_] | None

    @property
    def enumerated(self) -> bool:
        """Whether each row is one cluster."""
        return self.members is not None

    def names(self, row: int) -> tuple[int, ...] | None:
        """Robot indices of one cluster, None when the row stands for several."""
        return None if self.members is None else tuple(int(i) for i in np.flatnonzero(self.members[row]))


def family(problem: Problem) -> Family:
    """All non-empty subsets of up to 12 robots, or one bounding row per size beyond that."""
    return _every(problem) if problem.p <= LARGEST_ENUMERATION else _bounds(problem)


def _goal_distances(problem: Problem) -> Array:
    return np.asarray(np.linalg.norm(displacements(problem.goals), axis=2))


def _every(problem: Problem) -> Family:
    codes = np.arange(1, 2**problem.p)
    members = (codes[:, None] >> np.arange(problem.p)) & 1 == 1
    radii = -np.sort(np.where(members, -problem.radii, np.nan), axis=1)  # nan sorts last
    inside = members.astype(np.float64)
    spread = 0.5 * np.einsum("si,ij,sj->s", inside, _goal_distances(problem), inside, optimize=True)
    norms = inside @ np.linalg.norm(problem.goals, axis=1)
    return Family(members.sum(axis=1), radii, spread, norms, members)


def _bounds(problem: Problem) -> Family:
    """For n robots: the n largest radii and |g_i|, and the n smallest sums of n - 1 nearest distances."""
    p = problem.p
    sizes = np.arange(1, p + 1)
    largest = np.sort(problem.radii)[::-1]
    radii = np.where(np.arange(p) < sizes[:, None], largest, np.nan)
    nearest = np.sort(_goal_distances(problem), axis=1).cumsum(axis=1)  # [i, n-1]: to the n - 1 nearest
    spread = 0.5 * np.sort(nearest, axis=0).cumsum(axis=0)[sizes - 1, sizes - 1]
    norms = np.sort(np.linalg.norm(problem.goals, axis=1))[::-1].cumsum()
    return Family(sizes, radii, spread, norms, None)
