"""phi's factors and its reduced gradient: differences, the edge of free space, and the paper's statements."""

from functools import cache

import numpy as np
import pytest

from deploy.theory.exact_flow import classify, equilibria, swapped_pairs
from deploy.theory.function import (
    FleetProblem,
    gamma,
    obstacle_curvature,
    obstacle_functions,
    reduced_gradient,
    reduced_jacobian,
)
from protocol.arrays import Reals
from tests.deploy.theory.problems import SIZES, crowded, free, log_ratio

H = 1e-5  # for differences
CASES = [(p, unequal) for p in SIZES for unequal in (False, True)]


@pytest.mark.parametrize(("p", "unequal"), CASES)
@pytest.mark.parametrize("seed", range(2))
def test_derivatives_match_differences(p: int, unequal: bool, seed: int) -> None:
    """D = (gamma / k) grad log phi_hat, and its Jacobian."""
    problem = crowded(p, unequal, k=1.3 * p)
    b = free(problem, seed)
    steps = (H * np.eye(b.size)).reshape(b.size, *b.shape)
    slope = np.array([(log_ratio(problem, b + s) - log_ratio(problem, b - s)) / (2 * H) for s in steps])
    slope *= gamma(problem, b) / problem.k
    at = reduced_gradient(problem, b).ravel()
    np.testing.assert_allclose(at, slope, rtol=1e-4, atol=1e-5 * np.abs(slope).max())
    columns = [(reduced_gradient(problem, b + s) - reduced_gradient(problem, b - s)).ravel() for s in steps]
    expected = np.array(columns).T / (2 * H)
    found = reduced_jacobian(problem, b)
    np.testing.assert_allclose(found, expected, rtol=1e-5, atol=1e-6 * np.abs(expected).max())


def test_outside_free_space_there_is_no_gradient() -> None:
    problem = FleetProblem(np.array([[2.0, 0.0], [-2.0, 0.0]]), np.array([0.5, 0.5]), 4.0, 10.0)
    touching = np.array([[0.5, 0.0], [-0.5, 0.0]])
    two_negative = np.array([[3.8, 0.0], [3.8, 0.5]])  # whose product is positive
    for outside in (0.9 * touching, touching + 3.2, np.zeros((2, 2)), two_negative):
        assert np.isnan(reduced_gradient(problem, outside)).all()
        assert obstacle_functions(problem, outside).min() < 0.0
    large = FleetProblem(np.zeros((1, 2)), np.array([5.0]), 4.0, 10.0)
    assert obstacle_functions(large, np.zeros((1, 2))).min() < 0.0


@cache
def saddles(p: int, unequal: bool) -> tuple[FleetProblem, tuple[Reals, ...]]:
    """A crowded problem at k = 60 and its interior critical points other than the goal."""
    problem = crowded(p, unequal, k=60.0)
    starts = swapped_pairs(problem) + [free(problem, seed) for seed in range(4 if p == 6 else 12)]
    found = tuple(point.b for point in equilibria(problem, starts)[1:])
    assert found
    return problem, found


def n2_at(problem: FleetProblem, b: Reals) -> float:
    """gamma lambda_max(L1 L1^T - L0 L0^T) at one configuration: what N2 maximises; unbounded near contact."""
    return float(gamma(problem, b) * np.linalg.eigvalsh(obstacle_curvature(problem, b))[-1] / 2.0)


@pytest.mark.parametrize(("p", "unequal"), CASES)
def test_n2_of_proposition_d2_exceeds_k_at_every_saddle(p: int, unequal: bool) -> None:
    """Hence k > N2 excludes saddles in F1, against C.4; and N2 has no maximum: it grows towards contact."""
    problem, found = saddles(p, unequal)
    for b in found:
        if classify(problem, b).index > 0:
            assert n2_at(problem, b) > problem.k
    pair = FleetProblem(problem.goals[:2], problem.radii[:2], problem.workspace, problem.k)
    values = []
    for gap in (1e-2, 1e-4, 1e-6):
        b = np.array([(-pair.radii[0], 0.0), (pair.radii[1] + gap, 0.0)])
        values.append(n2_at(pair, b))
    assert values[2] > 50.0 * values[1] > 2500.0 * values[0]
