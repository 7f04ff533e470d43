"""The earlier law of Whitcomb and Koditschek, the gradient of gamma^k / beta: the same paths."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from deploy.theory.exact_flow import integrate
from deploy.theory.function import Array, Problem, in_free_space
from tests.deploy.theory.problems import crowded, free

STEP = 1e-6  # of the radius, for differences


def earlier(problem: Problem, b: Array) -> float:
    """log(gamma^k / beta), from its definition; infinite outside of free space."""
    if not in_free_space(problem, b):
        return np.inf
    gamma = ((b - problem.goals) ** 2).sum()
    log_beta = 0.0
    for i in range(problem.p):
        log_beta += np.log((problem.workspace - problem.radii[i]) ** 2 - (b[i] ** 2).sum())
        for j in range(i):
            contact = problem.radii[i] + problem.radii[j]
            log_beta += np.log(((b[i] - b[j]) ** 2).sum() - contact**2)
    return float(problem.k * np.log(gamma) - log_beta)


def direction(problem: Problem, b: Array) -> Array:
    """Of steepest descent of gamma^k / beta: by differences, of length 1."""
    step = STEP * problem.radii.min()
    slope = np.zeros(b.size)
    for n in range(b.size):
        aside = np.zeros(b.size)
        aside[n] = step
        ahead, behind = (b.ravel() + sign * aside for sign in (1.0, -1.0))
        slope[n] = earlier(problem, ahead.reshape(b.shape)) - earlier(problem, behind.reshape(b.shape))
    return np.asarray(-slope / np.linalg.norm(slope))


@pytest.mark.parametrize("seed", range(2))
def test_its_flow_has_the_same_paths(seed: int) -> None:
    problem, start = crowded(3, False, k=10.0), free(crowded(3, False, k=10.0), seed)
    ours = integrate(problem, start, accuracy=1e-7).path.reshape(-1, start.size)
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(ours, axis=0), axis=1))])
    length = 0.9 * along[-1]  # near the goal a path by its length turns ever faster

    def velocity(_: float, y: Array) -> Array:
        return direction(problem, y.reshape(start.shape))

    theirs = solve_ivp(velocity, (0.0, length), start.ravel(), method="LSODA", rtol=1e-6, atol=1e-9)
    assert theirs.success
    unit = problem.radii.min()
    for passed, there in zip(theirs.t, theirs.y.T, strict=True):
        here = np.array([np.interp(passed, along, ours[:, n]) for n in range(start.size)])
        assert np.linalg.norm(here - there) < 0.01 * unit
    assert along[-1] > 5.0 * unit  # there was a way to go
