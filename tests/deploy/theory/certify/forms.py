"""Bounds of the second-order tests against the Hessian itself; the module is an argument, for mutants."""

from __future__ import annotations

from collections.abc import Iterable
from types import ModuleType

import numpy as np

from deploy.theory.certify.boxes import Derived, Scene, derived, scene_of
from deploy.theory.certify.contractors import enclose
from deploy.theory.function import Array
from protocol.draws import Purpose, generator
from tests.deploy.theory.certify.known import Known

J = np.array([[0.0, 1.0], [-1.0, 0.0]])


def half_form(found: Known, v: Array) -> float:
    """v^T H v / 2 without -2 (y . v)^2 / gamma, H = gamma kappa Hess(log phi^), by M and the gradients."""
    problem, b = found.problem, found.point.b
    scene, row, n = scene_of(problem), found.row, 2 * problem.p
    turn = v.reshape(-1, 2)
    total = float((turn**2).sum())
    for q, (i, j) in enumerate(zip(scene.first, scene.second, strict=True)):
        apart = b[i] if j < 0 else b[i] - b[j]
        move = turn[i] if j < 0 else turn[i] - turn[j]
        beta = (apart @ apart - scene.contact[q].mean()) * (-1.0 if j < 0 else 1.0)
        total += row[n + q] * (move @ move) * (1.0 if j < 0 else -1.0)
        total += 2.0 * row[n + q] / beta * (apart @ move) ** 2
    return total


def around(found: Known, width: float) -> tuple[Scene, Array, Derived]:
    """A box about the point, of this relative width, with all that is derived from it."""
    scene, row = scene_of(found.problem), found.row
    n = 2 * found.problem.p
    margin = width * np.where(np.arange(len(row)) < n, 0.1, np.abs(row))
    box = np.stack([row - margin, row + margin], axis=1)
    out = derived(scene)
    assert enclose(scene, box, out)
    return scene, box, out


def circling_is_bounded(turning: ModuleType, points: Iterable[Known]) -> None:
    """Circling: the bound is one, and close, at every point where it is of use."""
    for found in points:
        scene, box, out = around(found, 1e-9)
        for q, (i, j) in enumerate(zip(scene.first, scene.second, strict=True)):
            for robot in (i, j) if j >= 0 else (i,):
                v = np.zeros_like(found.point.b)
                v[robot] = J @ (found.point.b[i] - (found.point.b[j] if j >= 0 else 0.0))
                exact, bound = half_form(found, v.ravel()), turning.circle(scene, box, out, q, robot)
                assert bound >= exact - 1e-9
                assert bound == np.inf or bound <= exact + 1e-3


def fields_are_orthogonal(curvature: ModuleType, points: Iterable[Known]) -> None:
    """The corrected field holds, for every b of a box, v - W z orthogonal to the chosen gradients."""
    for number, found in enumerate(points):
        draw = generator(number, Purpose.STUDY)
        scene, box, out = around(found, 3e-2)
        n = len(scene.goals)
        stiff = draw.integers(len(scene.first), size=1)
        v, field = draw.standard_normal(n), np.empty((n, 2))
        assert curvature.corrected(scene, box, out, stiff, v, field)
        w = gradient(scene, box[:n].mean(axis=1), stiff[0])
        for _ in range(10):
            row = gradient(scene, draw.uniform(box[:n, 0], box[:n, 1]), stiff[0])
            exact = v - w * (row @ v) / (row @ w)
            assert ((field[:, 0] - 1e-12 <= exact) & (exact <= field[:, 1] + 1e-12)).all()


def form_is_bounded(curvature: ModuleType, points: Iterable[Known]) -> None:
    """The quadratic form: bounded from above, and closely."""
    for number, found in enumerate(points):
        scene, box, out = around(found, 1e-9)
        v = generator(number, Purpose.STUDY).standard_normal(len(scene.goals))
        none = np.empty(0, dtype=np.int64)
        bound = curvature.form(scene, box, out, none, np.stack([v, v], axis=1))
        exact = half_form(found, v)
        assert exact - 1e-9 * abs(exact) <= bound <= exact + 1e-3 * abs(exact) + 1e-3


def gradient(scene: Scene, b: Array, q: int) -> Array:
    """grad beta_q / 2."""
    row, i, j = np.zeros_like(b), scene.first[q], scene.second[q]
    apart = b[2 * i : 2 * i + 2] - (b[2 * j : 2 * j + 2] if j >= 0 else 0.0)
    row[2 * i : 2 * i + 2] = -apart if j < 0 else apart
    if j >= 0:
        row[2 * j : 2 * j + 2] = -apart
    return row
