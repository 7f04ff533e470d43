"""Critical points that multi-start finds for random goal sets, and boxes that hold one."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache

import numpy as np

from deploy.theory.certify.boxes import scene_of
from deploy.theory.exact_flow import (
    CriticalPoint,
    classify,
    find_equilibrium,
    integrate,
    random_configuration,
    swapped_pairs,
)
from deploy.theory.function import FleetProblem, gamma, obstacle_functions
from protocol.arrays import Reals
from protocol.draws import Purpose, generator

WORKSPACE = 0.3
J = np.array([[0.0, 1.0], [-1.0, 0.0]])
FIGURE_2 = np.array([(0.0, 0.049), (-0.0425, -0.0245), (0.0425, -0.0245)])


@dataclass(frozen=True)
class Known:
    problem: FleetProblem
    point: CriticalPoint

    @property
    def row(self) -> Reals:
        """(b, lambda, kappa)."""
        problem, b = self.problem, self.point.b
        beta = np.roll(obstacle_functions(problem, b), -problem.p)  # pairs first
        weights = gamma(problem, b) / problem.k / beta
        return np.concatenate([b.ravel(), weights, [1.0 / problem.k]])


def random_problem(seed: int) -> FleetProblem:
    """2 to 4 robots of equal or unequal radii; crowded goals and a low k every third time, for minima."""
    draw = generator(seed, Purpose.STUDY)
    p = 2 + seed % 3
    radii = np.full(p, 0.04) if draw.random() < 0.5 else draw.uniform(0.03, 0.05, p)
    crowded = seed % 3 == 1 or draw.random() < 0.3
    goals = random_configuration(draw, radii, (0.13 + 0.02 * p) if crowded else WORKSPACE)
    k = draw.uniform(1.5, 4.0) if crowded else np.exp(draw.uniform(np.log(1.5), np.log(300.0)))
    return FleetProblem(goals, radii, WORKSPACE, float(k))


@cache
def known(seed: int) -> tuple[Known, ...]:
    """What multi-start finds for one goal set."""
    problem = random_problem(seed)
    draw = generator(seed, Purpose.SCENARIO)
    places = [random_configuration(draw, problem.radii, WORKSPACE) for _ in range(4)]
    return tuple(_found(problem, [*(b for b in places if b is not None), *swapped_pairs(problem)]))


def _found(problem: FleetProblem, starts: list[Reals]) -> Iterator[Known]:
    for start in starts:
        b = find_equilibrium(problem, start)
        if b is not None and gamma(problem, b) > 1e-8:
            yield Known(problem, classify(problem, b))


def blockade(k: float) -> Known:
    """Figure 2's first robot below the two others, all on the wrong side: a minimum for k = 1.6 to 2.4."""
    problem = FleetProblem(FIGURE_2, np.full(3, 0.04), WORKSPACE, k)
    rest = integrate(problem, np.array([(0.0, -0.12), (-0.148, 0.055), (0.148, 0.055)])).path[-1]
    (found,) = _found(problem, [rest])
    assert found.point.kind == "minimum"
    return found


def forever(equal: bool) -> Known:
    """Four equal or three unequal robots with a minimum at every large k: no K exists (propositions.md)."""
    if equal:
        goals = np.array([(-0.0444, -0.0437), (0.0429, -0.0424), (-0.0407, 0.0476), (0.0422, 0.0386)])
        place = np.array([(-0.0494, -0.0486), (-0.0281, 0.0285), (0.0281, -0.0285), (0.0494, 0.0486)])
        radii = np.full(4, 0.04)
    else:
        goals = np.array([(0.0511, 0.0201), (0.0019, 0.0039), (-0.002, 0.0564)])
        place = np.array([(0.0166, 0.0459), (0.0, 0.0), (0.0345, 0.0345)])
        radii = np.array([0.0106, 0.0382, 0.0106])
    problem = FleetProblem(goals, radii, WORKSPACE, 1e5)
    start = 1.001 * (place - place.mean(axis=0)) + place.mean(axis=0)
    (found,) = _found(problem, [integrate(problem, start).path[-1]])
    assert found.point.kind == "minimum"
    return found


def boxes(known: Known, count: int, seed: int) -> Iterator[Reals]:
    """Boxes of all sizes that hold the point and every lambda; kappa is narrow, or reaches to 0."""
    draw = generator(seed, Purpose.STUDY, robot=1)
    n, row = 2 * known.problem.p, known.row
    for _ in range(count):
        width, share = 10.0 ** draw.uniform(-5.0, -0.3), draw.random(n)
        box = np.empty((len(row), 2))
        box[:n, 0], box[:n, 1] = row[:n] - share * width, row[:n] + (1.0 - share) * width
        box[n:-1] = 0.0, np.inf
        box[-1] = row[-1] * np.array([(0.0, 1.0), (0.75, 1.0), (0.99, 1.02)][draw.integers(3)])
        yield box


def holds(box: Reals, row: Reals) -> bool:
    slack = 1e-8 * np.maximum(1.0, np.abs(row))
    return bool(((box[:, 0] - slack <= row) & (row <= box[:, 1] + slack)).all())


def half_form(found: Known, v: Reals) -> float:
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
