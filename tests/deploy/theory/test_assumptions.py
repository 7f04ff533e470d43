"""Lambda' and Lambda'': chains attain them, no random cluster exceeds them."""

from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest

from deploy.theory.bounds import (
    Family,
    chain,
    family,
    first_objective,
    heavy_middle,
    smallest_contact,
    stretch,
)
from deploy.theory.function import Array, FleetProblem
from protocol.draws import Purpose, generator


def everyone(clusters: Family) -> int:
    """Row of the cluster of all robots."""
    return int(np.argmax(clusters.sizes))


def problem_of(radii: Array, workspace: float = 200.0) -> FleetProblem:
    return FleetProblem(np.zeros((len(radii), 2)), radii, workspace, 60.0)


def random_cluster(draw: np.random.Generator, radii: Array, eps: float) -> Array | None:
    """A connected cluster grown disk by disk at random bearings; None when two disks overlap."""
    order, b = draw.permutation(len(radii)), np.zeros((len(radii), 2))
    for rank in range(1, len(radii)):
        new, old = order[rank], order[draw.integers(max(0, rank - 2), rank)]
        bearing = draw.normal(0.0, 0.6) if draw.random() < 0.7 else draw.uniform(0.0, 6.3)
        length = np.sqrt((radii[new] + radii[old]) ** 2 + eps * draw.uniform(0.3, 1.0))
        b[new] = b[old] + length * np.array([np.cos(bearing), np.sin(bearing)])
    gaps = np.linalg.norm(b[:, None] - b[None], axis=2) - radii[:, None] - radii[None]
    np.fill_diagonal(gaps, 1.0)
    return b if (gaps > 0.0).all() else None


@pytest.mark.slow
@pytest.mark.parametrize("n", [2, 3, 4, 6])
@pytest.mark.parametrize("unequal", [False, True])
def test_no_random_cluster_exceeds_the_bounds(n: int, unequal: bool) -> None:
    radii = np.linspace(2.0, 6.0, n) if unequal else np.full(n, 4.0)
    problem, eps = problem_of(radii), 5.0
    clusters = family(problem)
    lengths, row = stretch(problem, clusters, eps), everyone(clusters)
    spacing, draw, seen = smallest_contact(problem), generator(n, Purpose.STUDY), 0
    best = np.zeros(2)
    for _ in range(3000):
        b = random_cluster(draw, radii, eps)
        if b is None:
            continue
        seen += 1
        distances = np.linalg.norm(b[:, None] - b[None], axis=2)
        best = np.maximum(best, [first_objective(b, spacing), distances.sum(axis=1).max()])
    assert seen > 300
    assert best[0] <= lengths.first[row]
    assert best[1] <= lengths.second[row]
    assert best[0] > 0.55 * lengths.first[row]  # the search comes near, so the test could fail


@pytest.mark.parametrize("n", [2, 3, 6, 12])
def test_straight_chains_of_equal_disks_attain_both(n: int) -> None:
    radii, eps = np.full(n, 4.0), 3.0
    problem = problem_of(radii)
    clusters = family(problem)
    lengths, row = stretch(problem, clusters, eps), everyone(clusters)
    line, d = chain(radii, eps), np.sqrt(64.0 + eps)
    assert lengths.exact[row]
    assert lengths.first[row] == pytest.approx(first_objective(line, 8.0), rel=1e-12)
    assert lengths.second[row] == pytest.approx(float(np.abs(line[:, 0] - line[0, 0]).sum()), rel=1e-12)
    assert lengths.first[row] == pytest.approx(
        d * n * (n * n - 1) / 6 + (2 * n - 2) / 8 * d * d * n * (n * n - 1) / 12
    )
    assert lengths.second[row] == pytest.approx(d * n * (n - 1) / 2)


def test_unequal_chains_stay_below_the_bound_and_the_heavy_middle_comes_near() -> None:
    radii, eps = np.array([2.0, 3.0, 4.0, 5.0, 6.0]), 1.0
    problem = problem_of(radii)
    clusters = family(problem)
    lengths, row = stretch(problem, clusters, eps), everyone(clusters)
    spacing = smallest_contact(problem)
    values = [first_objective(chain(np.array(order), eps), spacing) for order in permutations(radii)]
    assert not lengths.exact[row]
    assert max(values) <= lengths.first[row]
    assert first_objective(chain(heavy_middle(radii), eps), spacing) == pytest.approx(max(values), rel=1e-12)


def test_a_chain_that_does_not_fit_is_clipped_and_not_called_exact() -> None:
    radii = np.full(6, 4.0)
    problem = problem_of(radii, workspace=20.0)
    clusters = family(problem)
    lengths, row = stretch(problem, clusters, 0.0), everyone(clusters)
    assert not lengths.exact[row]
    assert lengths.longest[row] == 2 * 16.0
    assert lengths.first[row] < stretch(problem_of(radii), clusters, 0.0).first[row]
