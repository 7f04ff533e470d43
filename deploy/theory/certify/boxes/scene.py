"""What is searched: boxes in (b, lambda, kappa), and the enclosures derived from one.

With y = b - g, gamma = |y|^2, kappa = 1/k and lambda_q = kappa gamma / beta_q, the critical points of
phi are the solutions of y_i = sum_j lambda_ij (b_i - b_j) - lambda_0i b_i. At kappa = 0 these are the
conditions of Karush, Kuhn and Tucker of projecting g on the free space, so kappa = 0 is no exception.

Row 2i + a of a box is axis a of robot i, row 2p + q is lambda_q (pairs row by row, then walls), the
last row is kappa; columns are lower and upper bound.
"""

from __future__ import annotations

from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from deploy.theory.certify.boxes.intervals import add, compiled, mul
from deploy.theory.function import Problem

Box = NDArray[np.float64]

_LARGEST = float(np.finfo(np.float64).max)


class Scene(NamedTuple):
    """A goal set. goals: (2p,) m; contact: (N, 2) m^2, enclosures of rho_q^2; first, second: (N,) robots.

    Factors q are the p (p - 1) / 2 pairs, then the p walls, for which `second` is -1.
    """

    goals: NDArray[np.float64]
    contact: NDArray[np.float64]
    first: NDArray[np.int64]
    second: NDArray[np.int64]


class Derived(NamedTuple):
    """Enclosures derived from a box. apart: (N, 2, 2), d_ij or b_i, axis by bound; pull: (2p, 2), y;

    beta: (N, 2) m^2; work: (N, 2), y . grad beta_q / 2; total: (2, 2), gamma and s = kappa gamma.
    """

    apart: NDArray[np.float64]
    pull: NDArray[np.float64]
    beta: NDArray[np.float64]
    work: NDArray[np.float64]
    total: NDArray[np.float64]


def scene_of(problem: Problem) -> Scene:
    """The scene of a goal set; the problem's k does not matter."""
    p = problem.p
    pairs = list(combinations(range(p), 2))
    first = np.array([i for i, _ in pairs] + list(range(p)), dtype=np.int64)
    second = np.array([j for _, j in pairs] + [-1] * p, dtype=np.int64)
    contact = np.empty((len(first), 2))
    for q, (i, j) in enumerate(zip(first, second, strict=True)):
        reach = float(problem.radii[i]), float(problem.radii[i])
        if j >= 0:
            other = float(problem.radii[j])
            distance = add(reach, (other, other))
        else:
            distance = add((problem.workspace, problem.workspace), (-reach[0], -reach[1]))
        contact[q] = mul(distance, distance)
    return Scene(np.ascontiguousarray(problem.goals, dtype=np.float64).ravel(), contact, first, second)


def derived(scene: Scene) -> Derived:
    """Room for the enclosures of one box."""
    n, factors = len(scene.goals), len(scene.first)
    return Derived(
        np.zeros((factors, 2, 2)),
        np.zeros((n, 2)),
        np.zeros((factors, 2)),
        np.zeros((factors, 2)),
        np.zeros((2, 2)),
    )


def whole(scene: Scene, kappa: tuple[float, float]) -> Box:
    """The box that holds every free configuration, every lambda, and these kappa."""
    n, factors = len(scene.goals), len(scene.first)
    box = np.empty((n + factors + 1, 2))
    for q, i in enumerate(scene.first):
        if scene.second[q] < 0:
            reach = np.nextafter(np.sqrt(scene.contact[q, 1]), np.inf)
            box[2 * i : 2 * i + 2] = -reach, reach
    box[n : n + factors] = 0.0, np.inf
    box[-1] = kappa
    return box


@compiled
def lower(array: NDArray[np.float64], row: int, bound: float) -> None:
    """Raise a lower bound; nan changes nothing, and what overflowed stands for the largest double."""
    if bound > array[row, 0]:
        array[row, 0] = min(bound, _LARGEST)


@compiled
def upper(array: NDArray[np.float64], row: int, bound: float) -> None:
    """Lower an upper bound, likewise."""
    if bound < array[row, 1]:
        array[row, 1] = max(bound, -_LARGEST)


@compiled
def inverted(box: Box, rows: int) -> bool:
    """Whether one of the first rows is empty."""
    found = False
    for row in range(rows):
        found = found or box[row, 0] > box[row, 1]
    return found
