"""Goals that no controller can reach: free space falls apart when three disks cannot stand in a line."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from agents.navigation.function import Array, Problem


def _orientation(b: Array, triple: tuple[int, int, int]) -> float:
    """Sign of the turn from robot i over j to k: +1 counter-clockwise, -1 clockwise."""
    (ax, ay), (bx, by) = b[triple[1]] - b[triple[0]], b[triple[2]] - b[triple[0]]
    return float(np.sign(ax * by - ay * bx))


def mirrored_triples(problem: Problem, start: Array) -> list[tuple[int, int, int]]:
    """Triples of robots (indices, from 0) whose goals are unreachable from `start`, whatever the controller.

    To change their orientation three centres must be collinear at some time, and then the disks take
    2 (rho_i + rho_j + rho_k) of one chord, at most 2 rho_0. So with rho_i + rho_j + rho_k > rho_0 the
    orientation of the triple never changes. The condition is sufficient for unreachability, not necessary.
    """
    stuck = []
    large = [int(i) for i in np.argsort(-problem.radii)]
    for triple in combinations(large, 3):
        if problem.radii[list(triple)].sum() <= problem.workspace:
            continue
        i, j, k = sorted(triple)
        if _orientation(start, (i, j, k)) != _orientation(problem.goals, (i, j, k)):
            stuck.append((i, j, k))
    return sorted(stuck)
