"""Interval arithmetic, and the boxes in (b, lambda, kappa) that are searched, with enclosures derived from
them.

With y = b - g, gamma = |y|^2, kappa = 1/k and lambda_q = kappa gamma / beta_q, the critical points of phi are
the solutions of y_i = sum_j lambda_ij (b_i - b_j) - lambda_0i b_i. At kappa = 0 these are the conditions of
Karush, Kuhn and Tucker of projecting g on the free space, so kappa = 0 is no exception.

Row 2i + a of a box is axis a of robot i, row 2p + q is lambda_q (pairs row by row, then walls), the last row
is kappa; columns are lower and upper bound.

Every bound of an interval (low, high) is moved to a representable number beyond the exact one by
multiplication. That needs only IEEE 754 round-to-nearest, not a rounding mode, which compilers may ignore. A
bound may be infinite; no operation forms inf - inf or 0 * inf from bounds that its docstring allows. Numba
compiles all inner loops of the search (extra `certify`).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from itertools import combinations
from typing import NamedTuple, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from deploy.theory.function import FleetProblem
from protocol.arrays import Reals
from protocol.process.installation import missing_library

try:
    from numba import njit
except ModuleNotFoundError as error:
    raise missing_library("a certificate", "numba", "certify") from error

F = TypeVar("F", bound=Callable[..., object])


def compiled(function: F) -> F:
    """The function as machine code, strictly IEEE: nothing is reassociated or flushed to zero. It is cached
    if this file's folder or the home can be written."""
    strictly = partial(njit, error_model="numpy", fastmath=False)
    try:
        return cast("F", strictly(cache=True)(function))
    except RuntimeError:
        return cast("F", strictly()(function))


Interval = tuple[float, float]

_LESS = 1.0 - 2.0**-52
_MORE = 1.0 + 2.0**-52
_TINY = 1e-300  # covers underflow


@compiled
def down(x: float) -> float:
    """A double below every real number that rounds to x."""
    return (x * _LESS if x > 0.0 else x * _MORE) - _TINY


@compiled
def up(x: float) -> float:
    """A double above every real number that rounds to x."""
    return (x * _MORE if x > 0.0 else x * _LESS) + _TINY


@compiled
def add(a: Interval, b: Interval) -> Interval:
    """a + b; lower bounds below +inf, upper bounds above -inf."""
    return down(a[0] + b[0]), up(a[1] + b[1])


@compiled
def sub(a: Interval, b: Interval) -> Interval:
    """a - b, as `add`."""
    return down(a[0] - b[1]), up(a[1] - b[0])


@compiled
def mul(a: Interval, b: Interval) -> Interval:
    """a b, both finite."""
    s, t, u, v = a[0] * b[0], a[0] * b[1], a[1] * b[0], a[1] * b[1]
    return down(min(s, t, u, v)), up(max(s, t, u, v))


@compiled
def weigh(weight: Interval, b: Interval) -> Interval:
    """weight b, with 0 <= weight, whose upper bound may be +inf, and finite b."""
    low = b[0] * (weight[1] if b[0] < 0.0 else weight[0])
    high = b[1] * (weight[1] if b[1] > 0.0 else weight[0])
    return down(low), up(high)


@compiled
def square(a: Interval) -> Interval:
    """a^2, finite; never below 0."""
    s, t = a[0] * a[0], a[1] * a[1]
    if a[0] <= 0.0 <= a[1]:
        return 0.0, up(max(s, t))
    return max(0.0, down(min(s, t))), up(max(s, t))


@compiled
def root_below(x: float) -> float:
    """A double at most the square root of x; 0 for x <= 0."""
    return max(0.0, down(math.sqrt(x))) if x > 0.0 else 0.0


@compiled
def root_above(x: float) -> float:
    """A double at least the square root of x; 0 for x <= 0."""
    return up(math.sqrt(x)) if x > 0.0 else 0.0


@compiled
def divide(a: Interval, b: Interval) -> Interval:
    """a / b; 0 is not in b, bounds of a may be infinite and those of b are finite."""
    s, t, u, v = a[0] / b[0], a[0] / b[1], a[1] / b[0], a[1] / b[1]
    return down(min(s, t, u, v)), up(max(s, t, u, v))


@compiled
def quotient(a: Interval, b: Interval) -> Interval:
    """a / b for a, b >= 0, whose bounds may be 0 or +inf; (0, inf) where b alone does not bound it."""
    low = down(a[0] / b[1]) if b[1] > 0.0 else 0.0
    high = up(a[1] / b[0]) if b[0] > 0.0 else np.inf
    return low, high


@compiled
def middle(a: Interval) -> float:
    """A double inside a finite interval, close to its middle."""
    return min(max(0.5 * (a[0] + a[1]), a[0]), a[1])


@compiled
def ends(array: Reals, row: int) -> Interval:
    """A row as an interval."""
    return array[row, 0], array[row, 1]


Box = Reals

_LARGEST = float(np.finfo(np.float64).max)


class Scene(NamedTuple):
    """A goal set. Factors q are the p (p - 1) / 2 pairs, then the p walls, for which `second` is -1."""

    goals: Reals  # (2p,) m
    contact: Reals  # (N, 2) m^2, enclosures of rho_q^2
    first: NDArray[np.int64]  # (N,) robots
    second: NDArray[np.int64]


class Derived(NamedTuple):
    """Enclosures derived from a box."""

    apart: Reals  # (N, 2, 2), d_ij or b_i, axis by bound
    pull: Reals  # (2p, 2), y
    beta: Reals  # (N, 2) m^2
    work: Reals  # (N, 2), y . grad beta_q / 2
    total: Reals  # (2, 2), gamma and s = kappa gamma


def scene_of(problem: FleetProblem) -> Scene:
    """The scene of a goal set, which is independent of k."""
    p = problem.p
    pairs = list(combinations(range(p), 2))
    first = np.array([i for i, _ in pairs] + list(range(p)), dtype=np.int64)
    second = np.array([j for _, j in pairs] + [-1] * p, dtype=np.int64)
    contact = np.empty((len(first), 2))
    for q, (i, j) in enumerate(zip(first, second, strict=True)):
        reach = float(problem.radii[i]), float(problem.radii[i])
        if j >= 0:
            other = float(problem.radii[j])
            distance = add(reach, (other, other))
        else:
            distance = add((problem.workspace, problem.workspace), (-reach[0], -reach[1]))
        contact[q] = mul(distance, distance)
    return Scene(np.ascontiguousarray(problem.goals, dtype=np.float64).ravel(), contact, first, second)


def derived(scene: Scene) -> Derived:
    """Uninitialised enclosures of one box."""
    n, factors = len(scene.goals), len(scene.first)
    return Derived(
        np.zeros((factors, 2, 2)),
        np.zeros((n, 2)),
        np.zeros((factors, 2)),
        np.zeros((factors, 2)),
        np.zeros((2, 2)),
    )


def whole(scene: Scene, kappa: tuple[float, float]) -> Box:
    """The box that contains every free configuration, every lambda, and these kappa."""
    n, factors = len(scene.goals), len(scene.first)
    box = np.empty((n + factors + 1, 2))
    for q, i in enumerate(scene.first):
        if scene.second[q] < 0:
            reach = np.nextafter(np.sqrt(scene.contact[q, 1]), np.inf)
            box[2 * i : 2 * i + 2] = -reach, reach
    box[n : n + factors] = 0.0, np.inf
    box[-1] = kappa
    return box


@compiled
def narrow(array: Reals, row: int, new: Interval) -> bool:
    """Intersect a row with an interval. False: nothing is left.

    A bound that is nan is ignored, and one that overflows becomes the largest double.
    """
    if new[0] > array[row, 0]:
        array[row, 0] = min(new[0], _LARGEST)
    if new[1] < array[row, 1]:
        array[row, 1] = max(new[1], -_LARGEST)
    return bool(array[row, 0] <= array[row, 1])


@compiled
def inverted(box: Box, rows: int) -> bool:
    """Whether one of the first `rows` rows is empty."""
    return bool((box[:rows, 0] > box[:rows, 1]).any())


_HUGE = 1e100  # an inverse with such entries is useless, and its products may overflow


@compiled
def lowest(matrix: Reals, vector: Reals) -> float:
    """Smallest eigenvalue of a symmetric matrix, and its vector; +inf if an entry is not finite."""
    if not np.isfinite(matrix).all():
        return np.inf
    values, vectors = np.linalg.eigh(matrix)
    vector[:] = vectors[:, 0]
    return float(values[0])


@compiled
def solve_into(matrix: Reals, inverse: Reals) -> bool:
    """Invert a matrix; False if it is singular or nearly so."""
    if not np.isfinite(matrix).all():
        return False
    try:
        inverse[:] = np.linalg.inv(matrix)
    except Exception:  # noqa: BLE001  compiled code knows no other type
        return False
    return bool((np.abs(inverse) < _HUGE).all())
