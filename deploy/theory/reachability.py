"""Goals that no controller can reach: free space falls apart when three disks cannot stand in a line."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from deploy.theory.function import Array, Problem


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
    return sorted(
        triple
        for triple in _wide_triples(problem)
        if _orientation(start, triple) != _orientation(problem.goals, triple)
    )


def _wide_triples(problem: Problem) -> Iterator[tuple[int, int, int]]:
    """Triples with rho_i + rho_j + rho_k > rho_0; largest first, so that few of many disks are looked at."""
    order = [int(i) for i in np.argsort(-problem.radii)]
    radius = problem.radii
    for first in range(problem.p - 2):
        for second in range(first + 1, problem.p - 1):
            for third in range(second + 1, problem.p):
                i, j, k = sorted((order[first], order[second], order[third]))
                if radius[[i, j, k]].sum() <= problem.workspace:
                    if third == second + 1 == first + 2:
                        return
                    break
                yield i, j, k
