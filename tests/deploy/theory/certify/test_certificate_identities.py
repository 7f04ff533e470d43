"""What the search rests on, at critical points found numerically; and results A to C of docs/theory."""

import numpy as np
import pytest

from deploy.theory.certify.boxes import scene_of
from deploy.theory.exact_flow import classify
from deploy.theory.function import FleetProblem, gamma, obstacle_functions, reduced_jacobian
from protocol.arrays import Reals
from protocol.draws import Purpose, generator
from tests.deploy.theory.certify.known import J, Known, half_form, known


def points() -> list[Known]:
    return [found for seed in range(20) for found in known(seed)]


def matrix(found: Known) -> Reals:
    """M = I - Laplacian(lambda_ij) + diag(lambda_0i)."""
    scene, row, p = scene_of(found.problem), found.row, found.problem.p
    m = np.eye(p)
    for q, (i, j) in enumerate(zip(scene.first, scene.second, strict=True)):
        weight = row[2 * p + q]
        if j < 0:
            m[i, i] += weight
        else:
            m[[i, j], [i, j]] -= weight
            m[[i, j], [j, i]] += weight
    return m


def at_goals(found: Known) -> float:
    """sum lambda_q beta_q(g)."""
    problem, p = found.problem, found.problem.p
    beta = np.roll(obstacle_functions(problem, problem.goals), -p)
    return float(found.row[2 * p : -1] @ beta)


@pytest.mark.slow
def test_a_critical_point_solves_a_linear_system_in_its_multipliers() -> None:
    for found in points():
        error = matrix(found) @ found.point.b - found.problem.goals
        assert np.abs(error).max() < 1e-6 * found.problem.workspace


@pytest.mark.slow
def test_the_form_is_that_of_the_hessian() -> None:
    """2 (half form) - 4 (y . v)^2 / gamma = v^T (dD/db) v, which is gamma kappa Hess(log phi^)."""
    for number, found in enumerate(points()):
        y = (found.point.b - found.problem.goals).ravel()
        v = generator(number, Purpose.STUDY).standard_normal(len(y))
        value = 2.0 * half_form(found, v) - 4.0 * (y @ v) ** 2 / gamma(found.problem, found.point.b)
        size = float(np.abs(found.point.spectrum).max() * (v @ v))
        assert value == pytest.approx(
            float(v @ reduced_jacobian(found.problem, found.point.b) @ v), abs=1e-6 * size
        )


def test_result_a_some_eigenvalue_of_m_is_negative() -> None:
    for found in points():
        problem, b, m = found.problem, found.point.b, matrix(found)
        y = b - problem.goals
        total, factors = gamma(problem, b), problem.p * (problem.p + 1) / 2
        value = float(np.einsum("ia,ij,ja->", y, m, y))
        expected = -(1.0 - factors / problem.k) * total - at_goals(found)
        assert value == pytest.approx(expected, rel=1e-5, abs=1e-7)
        if problem.k >= factors:
            assert np.linalg.eigvalsh(m)[0] <= -(1.0 - factors / problem.k) + 1e-6


def test_result_b_turning_the_displacement_or_the_fleet() -> None:
    for found in points():
        problem, b, goals = found.problem, found.point.b, found.problem.goals
        scene, p = scene_of(problem), problem.p
        total, kappa = gamma(problem, b), 1.0 / problem.k
        turned = 0.0
        for i, j in zip(scene.first, scene.second, strict=True):
            d, g = (b[i], goals[i]) if j < 0 else (b[i] - b[j], goals[i] - goals[j])
            reach = problem.contact[i, j] if j >= 0 else problem.reach[i]
            beta = (d @ d - reach**2) * (1.0 if j >= 0 else -1.0)
            turned += (d[0] * g[1] - d[1] * g[0]) ** 2 / beta**2
        expected = -(1.0 - p * (p + 1) / 2 * kappa) * total - at_goals(found) + 2.0 * total * kappa * turned
        value = half_form(found, ((b - goals) @ J.T).ravel())
        assert value == pytest.approx(expected, rel=1e-5, abs=1e-6)
        fleet = half_form(found, (b @ J.T).ravel())
        assert fleet == pytest.approx(float((b * goals).sum()), rel=1e-5, abs=1e-6)
        if (b * goals).sum() < -1e-9:
            assert found.point.index > 0


@pytest.mark.parametrize("k", [1.05, 1.5, 3.0, 60.0])
def test_result_c_two_robots_without_a_wall(k: float) -> None:
    """Along the line through the goals: lambda > 1/2, and turning the pair descends, for every k > 1."""
    rho, far = 0.08, 0.09
    wide = FleetProblem(np.array([(far / 2, 0.0), (-far / 2, 0.0)]), np.full(2, rho / 2), 1e6, k)
    kappa = 1.0 / k
    # (1 - 2 l) d = far, d^2 (1 - 2 kappa l) = rho^2 with d < 0: one l > 1/2, by bisection.
    low, high = 0.5 + 1e-12, 0.5 / kappa
    for _ in range(200):
        mid = 0.5 * (low + high)
        distance = far / (1.0 - 2.0 * mid)
        low, high = (mid, high) if distance**2 * (1.0 - 2.0 * kappa * mid) > rho**2 else (low, mid)
    b = wide.goals * (distance / far)
    beta = distance**2 - rho**2
    assert low > 0.5
    assert gamma(wide, b) * kappa / beta == pytest.approx(low, rel=1e-6)
    assert classify(wide, b).index > 0
