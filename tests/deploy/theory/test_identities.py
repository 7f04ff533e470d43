"""The paper's identities at critical points that were found numerically (appendices C and E)."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from deploy.theory.exact_flow import classify, equilibria, swapped_pairs
from deploy.theory.function import (
    Array,
    FleetProblem,
    beta_boundary,
    beta_pairs,
    gamma,
    obstacle_curvature,
    obstacle_functions,
    obstacle_outer,
    reduced_gradient,
    reduced_jacobian,
)
from tests.deploy.theory.clusters import circulation, clusters
from tests.deploy.theory.potential import n2_at
from tests.deploy.theory.problems import SIZES, admissible, crowded, free

CASES = [(p, unequal) for p in SIZES for unequal in (False, True)]


@cache
def saddles(p: int, unequal: bool) -> tuple[FleetProblem, tuple[Array, ...]]:
    """A crowded problem at k = 60 and its interior critical points other than the goal."""
    problem = crowded(p, unequal, k=60.0)
    starts = swapped_pairs(problem) + [free(problem, seed) for seed in range(4 if p == 6 else 12)]
    found = tuple(point.b for point in equilibria(problem, starts)[1:])
    assert found
    return problem, found


def pairs_of(p: int) -> list[tuple[int, int]]:
    """Q in the paper's order."""
    return [(i, j) for i in range(p) for j in range(i + 1, p)]


def stacked(b: Array) -> Array:
    """The paper's b = sum of b_i (x) e_i: all x coordinates, then all y."""
    return b.T.ravel()


def factors(problem: FleetProblem, b: Array) -> tuple[Array, Array, Array, Array]:
    """L0, L1, M, o of appendix E, built literally from their definitions."""
    p, unit = problem.p, np.eye(problem.p)
    pair, rim = beta_pairs(problem, b), beta_boundary(problem, b)
    outer = [-np.kron(np.eye(2), unit[i][None, :]) / np.sqrt(rim[i]) for i in range(p)]
    inner = [np.kron(np.eye(2), (unit[i] - unit[j])[None, :]) / np.sqrt(pair[i, j]) for i, j in pairs_of(p)]
    blocks = [block @ stacked(b) for block in outer + inner]
    m = np.zeros((2 * len(blocks), len(blocks)))
    for column, block in enumerate(blocks):
        m[2 * column : 2 * column + 2, column] = block
    o = np.concatenate([-np.ones(p), np.ones(len(inner))])
    return np.vstack(outer).T, np.vstack(inner).T, m, o


def robot_major(matrix: Array, p: int) -> Array:
    """The paper's x-then-y order to rows 2i + axis."""
    order = np.arange(2 * p).reshape(2, p).T.ravel()
    return matrix[np.ix_(order, order)]


@pytest.mark.parametrize(("p", "unequal"), CASES)
def test_critical_points_satisfy_lemma_e5(p: int, unequal: bool) -> None:
    """k beta grad gamma = gamma grad beta, divided by beta."""
    problem, found = saddles(p, unequal)
    for b in found:
        pair, rim = beta_pairs(problem, b), beta_boundary(problem, b)
        slope = np.zeros_like(b)
        for i in range(p):
            slope[i] = sum(2.0 * (b[i] - b[j]) / pair[i, j] for j in range(p) if j != i) - 2.0 * b[i] / rim[i]
        left, right = problem.k * 2.0 * (b - problem.goals), gamma(problem, b) * slope
        np.testing.assert_allclose(left, right, atol=1e-6 * np.abs(left).max())


@pytest.mark.parametrize(("p", "unequal"), CASES)
def test_hessian_of_phi_hat_at_critical_points_is_lemma_e13(p: int, unequal: bool) -> None:
    """beta/(2 gamma^k) D^2 phi_hat = half of D^2 log phi_hat there; the left side by differences of D."""
    problem, found = saddles(p, unequal)
    for b in found:
        scale, k = gamma(problem, b), problem.k
        h = 1e-5 * obstacle_functions(problem, b).min()
        steps = (h * np.eye(b.size)).reshape(b.size, *b.shape)

        def slope(x: Array, k: float = k) -> Array:
            return (k / gamma(problem, x) * reduced_gradient(problem, x)).ravel()

        left = np.array([(slope(b + s) - slope(b - s)) / (2 * h) for s in steps]).T / 2.0
        l0, l1, m, o = factors(problem, b)
        lm = np.hstack([l0, l1]) @ m
        right = (
            k / scale * np.eye(2 * p)
            + 2.0 * lm @ lm.T
            - 2.0 / k * np.outer(lm @ o, lm @ o)
            - l1 @ l1.T
            + l0 @ l0.T
        )
        np.testing.assert_allclose(left, robot_major(right, p), atol=1e-4 * np.abs(right).max())
        exact = k / (2.0 * scale) * reduced_jacobian(problem, b)
        np.testing.assert_allclose(exact, robot_major(right, p), atol=1e-7 * np.abs(right).max())


@pytest.mark.parametrize(("p", "unequal"), CASES)
def test_lemmas_e8_to_e11(p: int, unequal: bool) -> None:
    problem = crowded(p, unequal, k=60.0)
    b = free(problem, 5)
    l0, l1, m, o = factors(problem, b)
    both = np.hstack([l0, l1])
    assert np.linalg.matrix_rank(both) == 2 * p  # E.8
    steer = (2.0 * (b - problem.goals) - reduced_gradient(problem, b)) * problem.k / gamma(problem, b)
    np.testing.assert_allclose(2.0 * both @ m @ o, stacked(steer), rtol=1e-9, atol=1e-12)  # E.9
    curvature = robot_major(2.0 * (l1 @ l1.T - l0 @ l0.T), p)
    np.testing.assert_allclose(obstacle_curvature(problem, b), curvature, rtol=1e-10, atol=1e-14)  # E.10
    outer = robot_major(4.0 * both @ m @ m.T @ both.T, p)
    np.testing.assert_allclose(obstacle_outer(problem, b), outer, rtol=1e-10, atol=1e-14)  # E.11


@pytest.mark.parametrize(("p", "unequal"), CASES)
def test_circling_its_centroid_leads_a_cluster_off_a_saddle(p: int, unequal: bool) -> None:
    """Proposition C.4: v_z^T D^2 phi v_z < 0 for every cluster, where the assumptions hold and k is large."""
    problem = admissible(p, unequal, k=2000.0)
    eps = 2.0 * float(problem.radii.min()) ** 2
    points = equilibria(problem, swapped_pairs(problem))[1:]
    assert len(points) == p * (p - 1) // 2
    for point in points:
        cells = [cell for cell in clusters(problem, point.b, eps) if len(cell) >= 2]
        assert cells  # Propositions C.3 and C.5: critical points lie in F1(eps)
        for cell in cells:
            v = circulation(point.b, cell).ravel()
            assert v @ reduced_jacobian(problem, point.b) @ v < 0.0
        assert point.kind == "saddle"


@pytest.mark.parametrize(("p", "unequal"), CASES)
def test_n2_of_proposition_d2_exceeds_k_at_every_saddle(p: int, unequal: bool) -> None:
    """Hence k > N2 excludes saddles in F1, against C.4; and N2 has no maximum: it grows towards contact."""
    problem, found = saddles(p, unequal)
    for b in found:
        if classify(problem, b).index > 0:
            assert n2_at(problem, b) > problem.k
    b = problem.goals.copy()
    b[0], b[1] = (-problem.radii[0], 0.0), (problem.radii[1], 0.0)
    values = []
    for gap in (1e-2, 1e-4, 1e-6):
        b[1, 0] = problem.radii[1] + gap
        values.append(n2_at(problem, b[:2]) if p == 2 else n2_at(pair_of(problem), b[:2]))
    assert values[2] > 50.0 * values[1] > 2500.0 * values[0]


def pair_of(problem: FleetProblem) -> FleetProblem:
    """The same problem with its first two robots only."""
    return FleetProblem(problem.goals[:2], problem.radii[:2], problem.workspace, problem.k)
