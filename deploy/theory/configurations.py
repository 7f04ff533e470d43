"""Configurations of disks: random free ones, and goals that no controller can reach."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from agents.law.passages import gaps, separating
from deploy.theory.function import Array, Problem
from protocol.messages import Vector
from protocol.scenario.model import Scenario

DARTS = 500
ATTEMPTS = 2000


def random_configuration(draw: np.random.Generator, radii: Array, workspace: float) -> Array | None:
    """(p, 2) centres of disjoint disks, by dart throwing, largest first; None when no free one was found.

    Starts again when a disk finds no place.
    """
    order = np.argsort(-radii, kind="stable")
    for _ in range(ATTEMPTS):
        placed = _throw(draw, radii[order], workspace)
        if placed is not None:
            out = np.empty_like(placed)
            out[order] = placed
            return out
    return None


def _throw(draw: np.random.Generator, radii: Array, workspace: float) -> Array | None:
    placed = np.empty((0, 2))
    for i, radius in enumerate(radii):
        darts = draw.uniform(-workspace, workspace, (DARTS, 2))
        inside = np.hypot(*darts.T) < workspace - radius
        gaps = np.linalg.norm(darts[:, None] - placed[None], axis=2) - radius - radii[:i]
        free = np.flatnonzero(inside & (gaps > 0.0).all(axis=1))
        if not len(free):
            return None
        placed = np.vstack([placed, darts[free[0]]])
    return placed


class Barrier(NamedTuple):
    """Obstacles that separate a robot's goal from its start, other robots and all parts away.

    Of all ways there the widest is `width` (m) wide where it is narrowest, at (x, y), m.
    """

    robot: int
    width: float
    x: float
    y: float


def barriers(scenario: Scenario) -> list[Barrier]:
    """Robots whose goals no controller reaches while all obstacles stand; an exact decision."""
    room, obstacles = scenario.workspace.shape, [thing.shape for thing in scenario.obstacles]
    found = []
    near = gaps(room, obstacles, 2.0 * max(spec.radius for spec in scenario.robots))
    for spec in scenario.robots:
        closed = [gap for gap in near if gap.width < 2.0 * spec.radius]
        gap = separating(obstacles, closed, spec.start, spec.goal)
        if gap is not None:
            found.append(Barrier(spec.id, gap.width, *_middle(gap.begin, gap.end)))
    return found


def _middle(a: Vector, b: Vector) -> Vector:
    return 0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])


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
