"""Second derivatives against differences and sympy; Proposition D.1."""

from __future__ import annotations

import numpy as np
import pytest

from deploy.theory.function import Problem, reduced_gradient
from deploy.theory.hessian import reduced_jacobian
from tests.deploy.theory.potential import gradient, hessian, log_beta, phi
from tests.deploy.theory.problems import SIZES, crowded, free

H = 1e-5


@pytest.mark.parametrize("p", SIZES)
@pytest.mark.parametrize("unequal", [False, True])
@pytest.mark.parametrize("seed", range(3))
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


def test_hessian_agrees_with_sympy() -> None:
    import sympy

    problem = Problem(np.array([[1.0, 1.0]]), np.array([1.0]), 5.0, 2.0)
    b = np.array([[-2.0, 0.5]])
    x, y = sympy.symbols("x y")
    attract = (x - 1) ** 2 + (y - 1) ** 2
    exact = sympy.sqrt(attract**2 / (attract**2 + 16 - x**2 - y**2))
    expected = sympy.hessian(exact, (x, y)).subs({x: -2, y: sympy.Rational(1, 2)})
    np.testing.assert_allclose(hessian(problem, b), np.array(expected, dtype=float), rtol=1e-12)


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
