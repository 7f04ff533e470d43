"""The paper's continuous flow of the whole configuration, integrated to a tolerance: the reference for nrl.

b_i' = -s_i(b) D_i(b). With a factor common to all robots only the timing changes, so "common" integrates
b' = -D itself; "own" divides each slice by its own length, or near the goal by a constant, which is
another path that descends too. The repulsive layer is stiff: a linearly implicit (Rosenbrock) method of
order two with an error estimate is used (Shampine and Reichelt, The MATLAB ODE suite, 1997, ode23s).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from deploy.theory.function import Array, Problem, reduced_gradient
from deploy.theory.hessian import reduced_jacobian

Pace = Literal["common", "own"]
_D = 1.0 / (2.0 + np.sqrt(2.0))
_E32 = 6.0 + np.sqrt(2.0)
_HALVINGS = 20  # of the last step, to find where the flow arrives


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
    residual: float  # largest |D_i| at the end, m: small without arrival means another equilibrium


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


def _step(field: Field, b: Array, velocity: Array, jacobian: Array, h: float) -> tuple[Array, Array, Array]:
    """One Rosenbrock step: new configuration, its velocity, local error."""
    shape = b.shape
    inverse = np.linalg.inv(np.eye(b.size) - h * _D * jacobian)

    def solve(rhs: Array) -> Array:
        return np.asarray((inverse @ rhs.ravel()).reshape(shape))

    k1 = solve(velocity)
    middle = field.velocity(b + 0.5 * h * k1)
    k2 = solve(middle - k1) + k1
    new = b + h * k2
    end = field.velocity(new)
    k3 = solve(end - _E32 * (k2 - middle) - 2.0 * (k1 - velocity))
    return new, end, h / 6.0 * (k1 - 2.0 * k2 + k3)


def integrate(
    problem: Problem,
    start: Array,
    pace: Pace = "common",
    *,
    tolerance: float | None = None,
    ease: float | None = None,
    accuracy: float = 1e-3,
    max_steps: int = 20_000,
) -> FlowResult:
    """Follow the flow from `start` (p, 2) until every robot is within `tolerance` (m) of its goal.

    tolerance: a hundredth of the smallest radius unless given; ease: |D_i| (m) below which "own" slows
    down, the smallest radius unless given; accuracy: local error per step in units of the smallest radius.
    Ends without arrival at another equilibrium or after `max_steps`.
    """
    unit = float(problem.radii.min())
    near = 0.01 * unit if tolerance is None else tolerance
    field = Field(problem, pace, unit if ease is None else ease)
    b, path, h = start, [start], 1e-3
    velocity, jacobian = field.velocity(b), field.jacobian(b)
    for _ in range(max_steps):
        if _far(problem, b) <= near or np.abs(velocity).max() < 1e-9 * unit or h < 1e-15:
            break
        new, end, error = _step(field, b, velocity, jacobian, h)
        ratio = float(np.abs(error).max()) / (accuracy * unit)
        if np.isfinite(ratio) and np.isfinite(end).all() and ratio <= 1.0:
            b, velocity = new, end
            jacobian = field.jacobian(b)
            path.append(b)
            h *= min(4.0, 0.8 * max(ratio, 1e-6) ** (-1.0 / 3.0))
        else:
            h *= max(0.2, 0.8 * ratio ** (-1.0 / 3.0)) if np.isfinite(ratio) else 0.25
    path[-1] = _cut(problem, path, near)
    return _summary(problem, np.array(path), near)


def _cut(problem: Problem, path: list[Array], near: float) -> Array:
    """The first place of the last step, taken as straight, at which every robot is near; or its end."""
    if len(path) < 2 or _far(problem, path[-1]) > near:
        return path[-1]
    begin, way, low, high = path[-2], path[-1] - path[-2], 0.0, 1.0
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if _far(problem, begin + middle * way) <= near else (middle, high)
    return np.asarray(begin + high * way)


def _far(problem: Problem, b: Array) -> float:
    """Largest distance of a robot from its goal, m."""
    return float(np.hypot(*(b - problem.goals).T).max())


def _summary(problem: Problem, path: Array, near: float) -> FlowResult:
    lengths = np.linalg.norm(np.diff(path, axis=0), axis=2).sum(axis=0)
    straight = np.linalg.norm(path[0] - problem.goals, axis=1).sum()
    residual = np.linalg.norm(reduced_gradient(problem, path[-1]), axis=1).max()
    nrl = float(lengths.sum() / straight) if straight > 0.0 else 1.0
    return FlowResult(_far(problem, path[-1]) <= near, path, lengths, nrl, float(residual))
