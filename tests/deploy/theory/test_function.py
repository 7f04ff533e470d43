"""phi and its first derivatives: finite differences, sympy, extremes, and the rules at the boundary."""

from __future__ import annotations

from dataclasses import replace

import mpmath
import numpy as np
import pytest

from deploy.theory.function import (
    Array,
    FleetProblem,
    beta_boundary,
    beta_pairs,
    gamma,
    in_free_space,
    obstacle_functions,
    reduced_gradient,
    reduced_jacobian,
    weighted_obstacle_gradient,
)
from tests.deploy.theory.potential import boundary_gradient, gradient, hessian, log_beta, phi
from tests.deploy.theory.problems import SIZES, crowded, free

H = 1e-5  # for differences


def difference(problem: FleetProblem, b: Array) -> Array:
    """Central differences of phi, (p, 2)."""
    steps = (H * np.eye(b.size)).reshape(b.size, *b.shape)
    return np.array([(phi(problem, b + s) - phi(problem, b - s)) / (2 * H) for s in steps]).reshape(b.shape)


@pytest.mark.parametrize("p", SIZES)
@pytest.mark.parametrize("unequal", [False, True])
@pytest.mark.parametrize("seed", range(2))
def test_gradient_is_the_derivative_of_phi(p: int, unequal: bool, seed: int) -> None:
    problem = crowded(p, unequal, k=1.3 * p)
    b = free(problem, seed)
    expected = difference(problem, b)
    assert np.abs(expected).max() > 1e-7
    np.testing.assert_allclose(gradient(problem, b), expected, rtol=1e-4, atol=1e-5 * np.abs(expected).max())


def test_phi_and_gradient_agree_with_their_definition_in_fifty_digits() -> None:
    problem = FleetProblem(np.array([[5.0, 1.0], [-4.0, 2.0]]), np.array([1.0, 2.0]), 9.0, 3.0)
    b = np.array([[-3.0, 4.0], [3.0, -2.5]])

    def exact(*x: mpmath.mpf) -> mpmath.mpf:
        attract = sum((xi - gi) ** 2 for xi, gi in zip(x, problem.goals.ravel().tolist(), strict=True))
        apart = (x[0] - x[2]) ** 2 + (x[1] - x[3]) ** 2 - 9
        beta = apart * (64 - x[0] ** 2 - x[1] ** 2) * (49 - x[2] ** 2 - x[3] ** 2)
        return mpmath.cbrt(attract**3 / (attract**3 + beta))

    with mpmath.workdps(50):
        at = [mpmath.mpf(x) for x in b.ravel().tolist()]
        value = float(exact(*at))
        slope = [float(mpmath.diff(exact, at, tuple(int(n == m) for m in range(4)))) for n in range(4)]
    assert phi(problem, b) == pytest.approx(value, rel=1e-14)
    np.testing.assert_allclose(gradient(problem, b).ravel(), slope, rtol=1e-12)


def test_two_hundred_robots_at_k_ten_thousand_stay_finite_and_right() -> None:
    p, workspace = 200, 60.0
    side = np.arange(-8, 9) * 4.2
    grid = np.array([(x, y) for x in side for y in side if np.hypot(x, y) < 50.0])[:p]
    problem = FleetProblem(grid[::-1] * 1.01, np.full(p, 1.5), workspace, 10_000.0)
    b = grid + 0.1
    assert in_free_space(problem, b)
    assert 0.0 < phi(problem, b) < 1.0
    assert np.isfinite(log_beta(problem, b))
    reduced = reduced_gradient(problem, b)
    steps = (1e-4 * np.eye(b.size)).reshape(b.size, *b.shape)[:20]
    # D = (gamma / k) grad log phi_hat: differences of the logarithm, whose scale does not underflow
    log = [k_log(problem, b + s) - k_log(problem, b - s) for s in steps]
    expected = np.array(log) / 2e-4 * gamma(problem, b) / problem.k
    np.testing.assert_allclose(reduced.ravel()[:20], expected, rtol=1e-4, atol=1e-3)


def k_log(problem: FleetProblem, b: Array) -> float:
    """log phi_hat, written independently of the code under test."""
    return float(problem.k * np.log(((b - problem.goals) ** 2).sum())) - log_beta(problem, b)


@pytest.mark.parametrize("k", [1.0, 20.0, 10_000.0])
def test_phi_is_zero_at_the_goal_one_on_the_boundary_and_nan_outside(k: float) -> None:
    problem = FleetProblem(np.array([[2.0, 0.0], [-2.0, 0.0]]), np.array([0.5, 0.5]), 4.0, k)
    assert phi(problem, problem.goals) == 0.0
    assert (gradient(problem, problem.goals) == 0.0).all()
    touching = np.array([[0.5, 0.0], [-0.5, 0.0]])
    assert phi(problem, touching) == 1.0
    assert phi(problem, np.array([[3.5, 0.0], [0.0, 0.0]])) == 1.0
    for outside in (0.9 * touching, touching + 3.2, np.zeros((2, 2))):
        assert np.isnan(phi(problem, outside))
        assert np.isnan(reduced_gradient(problem, outside)).all()
        assert not in_free_space(problem, outside)


def test_two_negative_obstacle_functions_do_not_cancel() -> None:
    problem = FleetProblem(np.array([[2.0, 0.0], [-2.0, 0.0]]), np.array([0.5, 0.5]), 4.0, 10.0)
    both = np.array([[3.8, 0.0], [3.8, 0.5]])
    assert (
        np.prod(obstacle_functions(problem, both)) < 0.0 or (obstacle_functions(problem, both) < 0).sum() > 1
    )
    assert np.isnan(phi(problem, both))


def test_a_disk_larger_than_the_workspace_is_never_free() -> None:
    problem = FleetProblem(np.zeros((1, 2)), np.array([5.0]), 4.0, 10.0)
    assert not in_free_space(problem, np.zeros((1, 2)))


def contacts(p: int, unequal: bool) -> tuple[FleetProblem, Array]:
    """A configuration in which robots 0 and 1 touch exactly, along the x axis, and no others."""
    problem = crowded(p, unequal, k=1.5)
    for seed in range(50):
        b = free(problem, seed)
        b[1] = b[0] + (problem.contact[0, 1], 0.0)
        b[:2] = np.round(b[:2] * 64) / 64
        b[1, 0] = b[0, 0] + problem.contact[0, 1]
        if (values := obstacle_functions(problem, b)).min() == 0.0 and (values == 0.0).sum() == 1:
            others = float(np.log(values[values > 0.0]).sum())
            return replace(problem, k=others / np.log(gamma(problem, b))), b  # gamma^k and beta alike in size
    raise AssertionError("no configuration with one contact found")


@pytest.mark.parametrize("p", SIZES)
@pytest.mark.parametrize("unequal", [False, True])
def test_one_contact_has_the_gradient_of_lemma_e4(p: int, unequal: bool) -> None:
    problem, b = contacts(p, unequal)
    limit = boundary_gradient(problem, b)
    assert np.abs(limit).max() > 0.0  # Proposition C.1
    inward = np.zeros_like(b)
    inward[:2] = [[-1.0, 0.0], [1.0, 0.0]]
    np.testing.assert_allclose(
        gradient(problem, b + 1e-9 * inward), limit, rtol=1e-5, atol=1e-6 * np.abs(limit).max()
    )
    slope = (phi(problem, b + 1e-6 * inward) - 1.0) / 1e-6
    assert slope == pytest.approx(float((limit * inward).sum()), rel=1e-3)


@pytest.mark.parametrize("p", SIZES)
def test_the_printed_sum_of_lemma_e4_lacks_a_bar(p: int) -> None:
    """As printed, sum of beta_ij grad beta_ij, it does not even have the direction of the gradient."""
    problem, b = contacts(p, unequal=False)
    pairs = beta_pairs(problem, b)
    np.fill_diagonal(pairs, 0.0)
    printed = -weighted_obstacle_gradient(b, pairs, beta_boundary(problem, b)).ravel()
    inward = np.zeros_like(b)
    inward[:2] = [[-1.0, 0.0], [1.0, 0.0]]
    true = gradient(problem, b + 1e-9 * inward).ravel()

    def alignment(x: Array) -> float:
        return float(x @ true / np.linalg.norm(x) / np.linalg.norm(true))

    assert alignment(boundary_gradient(problem, b).ravel()) > 0.9999
    assert alignment(printed) < 0.9


def test_two_contacts_are_critical_and_maximal() -> None:
    """Proposition C.2."""
    goals = np.array([[3.0, 3.0], [-3.0, 3.0], [0.0, -4.0]])
    problem = FleetProblem(goals, np.ones(3), 8.0, 1.5)
    row = np.array([[-2.0, 0.0], [0.0, 0.0], [2.0, 0.0]])
    assert (obstacle_functions(problem, row) == 0.0).sum() == 2
    assert phi(problem, row) == 1.0
    assert (boundary_gradient(problem, row) == 0.0).all()
    near, nearer = (np.abs(gradient(problem, row * (1 + gap))).max() for gap in (1e-6, 1e-9))
    assert 0.0 < nearer < 2e-3 * near


@pytest.mark.parametrize("p", SIZES)
@pytest.mark.parametrize("unequal", [False, True])
@pytest.mark.parametrize("seed", range(2))
def test_second_derivatives_match_differences(p: int, unequal: bool, seed: int) -> None:
    problem = crowded(p, unequal, k=1.3 * p)
    b = free(problem, seed)
    steps = (H * np.eye(b.size)).reshape(b.size, *b.shape)
    for first, second in ((gradient, hessian), (reduced_gradient, reduced_jacobian)):
        expected = np.array(
            [(first(problem, b + s) - first(problem, b - s)).ravel() / (2 * H) for s in steps]
        ).T
        np.testing.assert_allclose(
            second(problem, b), expected, rtol=1e-5, atol=1e-6 * np.abs(expected).max()
        )
    np.testing.assert_allclose(
        hessian(problem, b), hessian(problem, b).T, atol=1e-12 * np.abs(hessian(problem, b)).max()
    )


@pytest.mark.parametrize("p", SIZES)
@pytest.mark.parametrize("unequal", [False, True])
def test_goal_is_a_nondegenerate_minimum(p: int, unequal: bool) -> None:
    """Proposition D.1: D^2 phi(g) = 2 beta(g)^(-1/k) I, here against second differences of phi."""
    problem = crowded(p, unequal, k=6.0)
    expected = 2.0 * np.exp(-log_beta(problem, problem.goals) / problem.k)
    np.testing.assert_allclose(hessian(problem, problem.goals), expected * np.eye(2 * p), rtol=1e-12)
    for axis in range(2 * p):
        step = np.zeros((p, 2))
        step.flat[axis] = 1e-3
        second = (phi(problem, problem.goals + step) + phi(problem, problem.goals - step)) / 1e-6
        assert second == pytest.approx(expected, rel=1e-3)
