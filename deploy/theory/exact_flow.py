"""The paper's continuous flow b' = -D of all robots, integrated to a tolerance, and its equilibria.

The common factor of grad phi only changes the timing. The repulsive layer is stiff, hence SciPy's implicit
BDF method. Equilibria are found by nonlinear least squares on D = 0 and classified by the Hessian. Each is
real (its residual is checked), but some may be missed.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import combinations
from typing import Literal

import numpy as np
from scipy.integrate import BDF
from scipy.optimize import brentq, least_squares

from deploy.theory.function import FleetProblem, reduced_gradient, reduced_jacobian
from protocol.arrays import Reals
from protocol.process.signals import STOP

DARTS = 500
ATTEMPTS = 2000


def random_configuration(draw: np.random.Generator, radii: Reals, workspace: float) -> Reals | None:
    """Random centres (p, 2) of disjoint disks, by dart throwing, largest first; None if none was found."""
    for _ in range(ATTEMPTS):
        placed = np.full((len(radii), 2), np.inf)  # a disk overlaps nothing until it is thrown
        for i in np.argsort(-radii, kind="stable"):
            darts = draw.uniform(-workspace, workspace, (DARTS, 2))
            inside = np.hypot(*darts.T) < workspace - radii[i]
            gaps = np.linalg.norm(darts[:, None] - placed, axis=2) - radii[i] - radii
            free = np.flatnonzero(inside & (gaps > 0.0).all(axis=1))
            if not len(free):
                break
            placed[i] = darts[free[0]]
        else:
            return placed
    return None


_LONGEST = 20_000  # steps of the solver


@dataclass(frozen=True)
class FlowResult:
    """A trajectory of the flow."""

    arrived: bool
    path: Reals  # (n, p, 2) m, every accepted step, the last one cut at arrival
    nrl: float  # as in section 4


def integrate(
    problem: FleetProblem, start: Reals, *, tolerance: float | None = None, accuracy: float = 1e-5
) -> FlowResult:
    """Follow the flow from `start` (p, 2) until every robot is within `tolerance` (m) of its goal.

    tolerance: by default a hundredth of the smallest radius; accuracy: local error per step, relative and in
    units of the smallest radius. Ends without arrival at another equilibrium or after `_LONGEST` steps.
    """
    unit = float(problem.radii.min())
    near = 0.01 * unit if tolerance is None else tolerance
    b, path = start, [start]

    def velocity(_: float, y: Reals) -> Reals:
        return -reduced_gradient(problem, y.reshape(start.shape)).ravel()

    def jacobian(t: float, y: Reals) -> Reals:
        inside = np.isfinite(velocity(t, y)).all()  # a trial point may leave free space
        return -reduced_jacobian(problem, y.reshape(start.shape) if inside else b)

    flow = BDF(velocity, 0.0, start.ravel(), np.inf, jac=jacobian, rtol=accuracy, atol=accuracy * unit)
    for _ in range(_LONGEST):
        STOP.check()
        still = np.abs(reduced_gradient(problem, b)).max() < 1e-9 * unit
        if _far(problem, b) <= near or still or flow.step() is not None:
            break
        b = flow.y.reshape(start.shape)
        path.append(b)
    arrived = _far(problem, b) <= near
    if arrived and len(path) > 1:
        path[-1] = _cut(problem, path[-2], b, near)
    way = np.array(path)
    length = np.linalg.norm(np.diff(way, axis=0), axis=2).sum()
    straight = np.linalg.norm(start - problem.goals, axis=1).sum()
    return FlowResult(arrived, way, float(length / straight) if straight > 0.0 else 1.0)


def _cut(problem: FleetProblem, begin: Reals, end: Reals, near: float) -> Reals:
    """First point of the last step, taken as straight, at which every robot is near its goal."""
    share = brentq(lambda share: _far(problem, begin + share * (end - begin)) - near, 0.0, 1.0)
    return np.asarray(begin + share * (end - begin))


def _far(problem: FleetProblem, b: Reals) -> float:
    return float(np.hypot(*(b - problem.goals).T).max())


CriticalKind = Literal["minimum", "saddle", "maximum", "degenerate"]


@dataclass(frozen=True)
class CriticalPoint:
    """An equilibrium of the flow."""

    b: Reals  # (p, 2) m
    kind: CriticalKind
    index: int  # number of negative eigenvalues (its Morse index)
    spectrum: Reals  # (2p,) eigenvalues of (1/c) D^2 phi, increasing; 2 is the curvature of gamma


def classify(problem: FleetProblem, b: Reals, tolerance: float = 1e-6) -> CriticalPoint:
    """Classify a critical point `b` in the interior, where D^2 phi = c dD/db with c > 0.

    An eigenvalue is zero if below `tolerance`, relative to 2, or below rounding of the largest one.
    """
    jacobian = reduced_jacobian(problem, b)
    spectrum: Reals = np.asarray(np.linalg.eigvalsh(0.5 * (jacobian + jacobian.T)), dtype=np.float64)
    zero = 2.0 * tolerance + 1e-13 * float(np.abs(spectrum).max())
    index = int((spectrum < -zero).sum())
    return CriticalPoint(b, _kind(spectrum, index, zero), index, spectrum)


def _kind(spectrum: Reals, index: int, zero: float) -> CriticalKind:
    if (np.abs(spectrum) <= zero).any():
        return "degenerate"
    if index == 0:
        return "minimum"
    return "maximum" if index == len(spectrum) else "saddle"


_ROUNDING = 1e-15
_ZERO = 1e-7  # |D| in units of the smallest radius, above rounding in the stiff layer


def find_equilibrium(problem: FleetProblem, start: Reals, steps: int = 200) -> Reals | None:
    """An interior zero of D near `start` (p, 2), by SciPy's trust region; None if none is reached.

    Steps that leave free space (D is nan there) are shortened, so the boundary is never crossed.
    """
    unit = float(problem.radii.min())
    if not np.isfinite(reduced_gradient(problem, start)).all():
        return None
    found = least_squares(
        lambda y: reduced_gradient(problem, unit * y.reshape(start.shape)).ravel() / unit,
        start.ravel() / unit,
        lambda y: reduced_jacobian(problem, unit * y.reshape(start.shape)),
        ftol=_ROUNDING,
        xtol=_ROUNDING,
        gtol=_ROUNDING,
        max_nfev=steps,
    )
    return unit * found.x.reshape(start.shape) if np.abs(found.fun).max() < _ZERO else None


def swapped_pairs(problem: FleetProblem) -> list[Reals]:
    """Starts close to the saddles in which two robots block each other and the others are at their goals.

    The two are on the line through their goals in reversed order, at the distance where repulsion and
    attraction balance; only starts in the interior of free space.
    """
    starts = []
    for i, j in combinations(range(problem.p), 2):
        apart = problem.goals[i] - problem.goals[j]
        far, contact = float(np.linalg.norm(apart)), float(problem.contact[i, j])
        beta = (far + contact) * contact / problem.k  # gamma / (k alpha), alpha = |b_i - g_i| / delta_ij
        half = -0.5 * np.sqrt(contact**2 + beta) * apart / far
        b = problem.goals.copy()
        b[i], b[j] = (middle := 0.5 * (b[i] + b[j])) + half, middle - half
        if np.isfinite(reduced_gradient(problem, b)).all():
            starts.append(b)
    return starts


def equilibria(problem: FleetProblem, starts: Iterable[Reals]) -> tuple[CriticalPoint, ...]:
    """Distinct classified equilibria reached from the starts, the goal first."""
    unit = float(problem.radii.min())
    found = [classify(problem, problem.goals)]
    for start in starts:
        STOP.check()
        b = find_equilibrium(problem, start)
        if b is not None and all(np.abs(b - known.b).max() > 1e-4 * unit for known in found):
            found.append(classify(problem, b))
    return tuple(found)
