"""The paper's continuous flow of the whole configuration, integrated to a tolerance: the reference for nrl.

b_i' = -s_i(b) D_i(b). With a factor common to all robots only the timing changes, so "common" integrates
b' = -D itself; "own" divides each slice by its own length, or near the goal by a constant, which is
another path that descends too. The repulsive layer is stiff: SciPy's implicit BDF method is used.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from scipy.integrate import BDF
from scipy.optimize import brentq

from deploy.theory.function import Array, Problem, reduced_gradient, reduced_jacobian

Pace = Literal["common", "own"]


@dataclass(frozen=True)
class FlowResult:
    """Where the flow went.

    path: (n, p, 2) m, every accepted step, the last cut where all have arrived; lengths: (p,) m; nrl as
    in section 4.
    """

    arrived: bool
    path: Array
    lengths: Array
    nrl: float


@dataclass(frozen=True)
class Field:
    """The vector field of one problem at one pace; `ease` (m) is the |D_i| below which "own" slows down."""

    problem: Problem
    pace: Pace
    ease: float

    def velocity(self, b: Array) -> Array:
        """(p, 2); nan outside the interior of free space."""
        reduced = reduced_gradient(self.problem, b)
        return -reduced if self.pace == "common" else -reduced / self._length(reduced)

    def jacobian(self, b: Array) -> Array:
        """d velocity / db, (2p, 2p)."""
        outer = reduced_jacobian(self.problem, b)
        if self.pace == "common":
            return -outer
        reduced = reduced_gradient(self.problem, b)
        length = self._length(reduced)
        unit = np.where(length > self.ease, reduced / length, 0.0)
        rows = outer.reshape(self.problem.p, 2, -1)
        along = unit[:, :, None] * np.einsum("ia,iaj->ij", unit, rows)[:, None, :]
        return np.asarray((-(rows - along) / length[:, :, None]).reshape(outer.shape))

    def _length(self, reduced: Array) -> Array:
        return np.asarray(np.maximum(np.linalg.norm(reduced, axis=1, keepdims=True), self.ease))


def integrate(
    problem: Problem,
    start: Array,
    pace: Pace = "common",
    *,
    tolerance: float | None = None,
    ease: float | None = None,
    accuracy: float = 1e-5,
    max_steps: int = 20_000,
) -> FlowResult:
    """Follow the flow from `start` (p, 2) until every robot is within `tolerance` (m) of its goal.

    tolerance: a hundredth of the smallest radius unless given; ease: |D_i| (m) below which "own" slows
    down, the smallest radius unless given; accuracy: local error per step, relative and in units of the
    smallest radius. Ends without arrival at another equilibrium or after `max_steps`.
    """
    unit = float(problem.radii.min())
    near = 0.01 * unit if tolerance is None else tolerance
    field, b, path = Field(problem, pace, unit if ease is None else ease), start, [start]

    def velocity(_: float, y: Array) -> Array:
        return field.velocity(y.reshape(start.shape)).ravel()

    def jacobian(t: float, y: Array) -> Array:
        inside = np.isfinite(velocity(t, y)).all()  # what is tried may not be
        return field.jacobian(y.reshape(start.shape) if inside else b)

    flow = BDF(velocity, 0.0, start.ravel(), np.inf, jac=jacobian, rtol=accuracy, atol=accuracy * unit)
    for _ in range(max_steps):
        still = np.abs(field.velocity(b)).max() < 1e-9 * unit
        if _far(problem, b) <= near or still or flow.step() is not None:
            break
        b = flow.y.reshape(start.shape)
        path.append(b)
    arrived = _far(problem, b) <= near
    if arrived and len(path) > 1:
        path[-1] = _cut(problem, path[-2], b, near)
    return _summary(problem, np.array(path), arrived)


def _cut(problem: Problem, begin: Array, end: Array, near: float) -> Array:
    """The first place of the last step, taken as straight, at which every robot is near."""
    share = brentq(lambda share: _far(problem, begin + share * (end - begin)) - near, 0.0, 1.0)
    return np.asarray(begin + share * (end - begin))


def _far(problem: Problem, b: Array) -> float:
    """Largest distance of a robot from its goal, m."""
    return float(np.hypot(*(b - problem.goals).T).max())


def _summary(problem: Problem, path: Array, arrived: bool) -> FlowResult:
    lengths = np.linalg.norm(np.diff(path, axis=0), axis=2).sum(axis=0)
    straight = np.linalg.norm(path[0] - problem.goals, axis=1).sum()
    nrl = float(lengths.sum() / straight) if straight > 0.0 else 1.0
    return FlowResult(arrived, path, lengths, nrl)


def arrives_from_all(problem: Problem, starts: Sequence[Array]) -> bool:
    """Whether the exact flow brings every one of these starts (p, 2) to the goal."""
    return all(integrate(problem, start).arrived for start in starts)


def arrival_threshold(
    problem: Problem, starts: Sequence[Array], low: float, high: float, ratio: float = 1.05
) -> tuple[float, float]:
    """(k at which some start fails, k at which all arrive), within a factor of `ratio`; ignores problem.k.

    Bisection on log k between `low`, taken to fail, and `high`, taken to arrive. It finds one change from
    failure to arrival; that arrival is monotone in k is observed, not proven.
    """
    while high > ratio * low:
        middle = float(np.sqrt(low * high))
        arrives = arrives_from_all(replace(problem, k=middle), starts)
        low, high = (low, middle) if arrives else (middle, high)
    return low, high
