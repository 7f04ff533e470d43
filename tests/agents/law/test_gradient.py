import math
from operator import attrgetter

import numpy as np
import pytest

from agents.law.gradient import Slice
from agents.peers.state import Peer
from deploy.theory.exact_flow import random_configuration
from deploy.theory.function import FleetProblem, reduced_gradient

numbers = attrgetter("dx", "dy", "xx", "xy", "yx", "yy")  # of a gradient


def configuration(n: int, k: float, seed: int) -> tuple[FleetProblem, np.ndarray]:
    rng = np.random.default_rng(seed)
    workspace = 0.30 * math.sqrt(n / 6)
    starts, goals = (random_configuration(rng, np.full(n, 0.04), workspace) for _ in range(2))
    return FleetProblem(goals, rng.uniform(0.02, 0.04, n), workspace, k), starts


def slice_of(problem: FleetProblem, b: np.ndarray, i: int) -> Slice:
    gammas = ((b - problem.goals) ** 2).sum(1)
    peers = [
        Peer(float(x), float(y), float(problem.radii[j]), float(gammas[j]))
        for j, (x, y) in enumerate(b)
        if j != i
    ]
    goal = (float(problem.goals[i][0]), float(problem.goals[i][1]))
    return Slice(goal, float(problem.radii[i]), problem.workspace, problem.k, peers)


@pytest.mark.slow
@pytest.mark.parametrize(("n", "k"), [(1, 60.0), (2, 5.0), (6, 60.0), (24, 960.0), (200, 10_000.0)])
def test_slices_are_the_rows_of_the_reduced_gradient(n: int, k: float) -> None:
    problem, b = configuration(n, k, seed=n)
    expected = reduced_gradient(problem, b)
    for i in range(n):
        own = slice_of(problem, b, i)
        value = own(*map(float, b[i]))
        assert np.isfinite(value).all()
        np.testing.assert_allclose(value, expected[i], rtol=1e-10, atol=1e-12)
        assert numbers(own.gradient(*map(float, b[i])))[:2] == value


@pytest.mark.parametrize("seed", range(3))
def test_jacobian_is_the_finite_difference(seed: int) -> None:
    problem, b = configuration(6, 60.0, seed)
    step = 1e-6
    for i in range(6):
        own, (x, y) = slice_of(problem, b, i), map(float, b[i])
        found = np.reshape(numbers(own.gradient(x, y))[2:], (2, 2))
        columns = [
            np.subtract(own(x + step, y), own(x - step, y)) / (2 * step),
            np.subtract(own(x, y + step), own(x, y - step)) / (2 * step),
        ]
        np.testing.assert_allclose(found, np.transpose(columns), rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize("k", [60.0, 10_000.0])
def test_at_and_behind_a_contact_the_slice_pushes_apart_the_more_the_deeper(k: float) -> None:
    own, pushes = Slice((0.2, 0.0), 0.04, 0.30, k, [Peer(0.1, 0.0, 0.04, 0.01)]), list[float]()
    for depth in (-1e-4, -1e-8, -1e-13, 0.0, 1e-9, 1e-8, 1e-4, 1e-3, 0.02, 0.03):
        dx, dy = own(0.02 + depth, 0.0)
        assert dx > 0.0 or depth < -1e-12
        assert (math.isfinite(dx), dy) == (True, 0.0)
        assert all(map(math.isfinite, numbers(own.gradient(0.02 + depth, 0.0))))
        pushes.append(dx)
    assert pushes == sorted(pushes)


def test_outside_the_workspace_the_slice_points_home() -> None:
    own = Slice((0.0, 0.0), 0.04, 0.30, 60.0, [Peer(-0.1, 0.0, 0.04, 0.01)])
    assert own(0.27, 0.0)[0] > 1e3
    assert all(map(math.isfinite, numbers(own.gradient(0.27, 0.0))))
