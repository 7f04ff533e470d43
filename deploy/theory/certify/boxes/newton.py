"""Interval Newton of Hansen and Sengupta in (b, lambda), with kappa as a parameter that is an interval.

Equations, with b0, lambda0 the midpoint: F_i = b_i - g_i - sum lambda_ij d_ij + lambda_0i b_i and
F_q = lambda_q beta_q - kappa gamma. For every (b, lambda) in the box F(b, lambda) - F(b0, lambda0) =
S (b - b0, lambda - lambda0), where the rows of S hold M(lambda0), d_q over the box, lambda0 (d + d0), beta_q
over the box, and kappa (y + y0). That is tighter than a Jacobian over the box, and exact at contact.

The dense linear algebra is NumPy's: what it finds is a proposal, never a bound.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from deploy.theory.certify.boxes.intervals import Interval, add, compiled, divide, middle, mul, square, sub
from deploy.theory.certify.boxes.scene import Box, Derived, Scene, inverted, lower, upper

Array = NDArray[np.float64]

_HUGE = 1e100  # an inverse with such entries is of no use, and its products might overflow


@compiled
def lowest(matrix: Array, vector: Array) -> float:
    """Smallest eigenvalue of a symmetric matrix, and its vector; +inf where an entry is not finite."""
    if not np.isfinite(matrix).all():
        return np.inf
    values, vectors = np.linalg.eigh(matrix)
    vector[:] = vectors[:, 0]
    return float(values[0])


@compiled
def solve_into(matrix: Array, inverse: Array) -> bool:
    """The inverse. False: singular, or as good as."""
    if not np.isfinite(matrix).all():
        return False
    try:
        inverse[:] = np.linalg.inv(matrix)
    except Exception:  # noqa: BLE001  compiled code tells no more of it
        return False
    return bool((np.abs(inverse) < _HUGE).all())


_LARGEST = 1e50  # multipliers beyond might overflow below


@compiled
def _point(x: float) -> Interval:
    return x, x


@compiled
def _put(slope: Array, row: int, column: int, value: Interval) -> None:
    slope[row, column] = value


@compiled
def _accumulate(array: Array, row: int, column: int, value: Interval) -> None:
    total = add((array[row, column, 0], array[row, column, 1]), value)
    array[row, column] = total


@compiled
def _system(scene: Scene, box: Box, out: Derived, at: Array, value: Array, slope: Array) -> None:
    """F at the midpoint `at`, for every kappa of the box, and S."""
    n, factors = len(scene.goals), len(scene.first)
    kappa = (box[-1, 0], box[-1, 1])
    slope[:] = 0.0
    gamma = (0.0, 0.0)
    for row in range(n):
        y = sub(_point(at[row]), _point(scene.goals[row]))
        value[row] = y
        gamma = add(gamma, square(y))
        slope[row, row] = 1.0, 1.0
        both = mul(kappa, add(y, (out.pull[row, 0], out.pull[row, 1])))
        for q in range(factors):
            slope[n + q, row] = -both[1], -both[0]
    target = mul(kappa, gamma)
    for q in range(factors):
        i, j = scene.first[q], scene.second[q]
        weight = _point(at[n + q])
        opposite = (-at[n + q], -at[n + q])
        far = (0.0, 0.0)
        for a in range(2):
            one, two = 2 * i + a, 2 * j + a
            there = _point(at[one]) if j < 0 else sub(_point(at[one]), _point(at[two]))
            here = (out.apart[q, a, 0], out.apart[q, a, 1])
            far = add(far, square(there))
            force = mul(weight, there)
            along = mul(weight, add(here, there))
            if j < 0:
                total = add((value[one, 0], value[one, 1]), force)
                value[one] = total
                _accumulate(slope, one, one, weight)
                _put(slope, one, n + q, here)
                _accumulate(slope, n + q, one, (-along[1], -along[0]))
            else:
                total = sub((value[one, 0], value[one, 1]), force)
                value[one] = total
                total = add((value[two, 0], value[two, 1]), force)
                value[two] = total
                _accumulate(slope, one, one, opposite)
                _accumulate(slope, two, two, opposite)
                _accumulate(slope, one, two, weight)
                _accumulate(slope, two, one, weight)
                _put(slope, one, n + q, (-here[1], -here[0]))
                _put(slope, two, n + q, here)
                _accumulate(slope, n + q, one, along)
                _accumulate(slope, n + q, two, (-along[1], -along[0]))
        contact = (scene.contact[q, 0], scene.contact[q, 1])
        beta = sub(contact, far) if j < 0 else sub(far, contact)
        total = sub(mul(weight, beta), target)
        value[n + q] = total
        slope[n + q, n + q] = out.beta[q]


@compiled
def contract_newton(scene: Scene, box: Box, out: Derived) -> bool:
    """Contract (b, lambda); nothing happens where a lambda is huge or the midpoint's S singular."""
    size = len(box) - 1
    for row in range(size):
        if not box[row, 1] < _LARGEST:
            return True
    at = np.empty(size)
    for row in range(size):
        at[row] = middle((box[row, 0], box[row, 1]))
    value, slope = np.empty((size, 2)), np.empty((size, size, 2))
    _system(scene, box, out, at, value, slope)
    centre, inverse = np.empty((size, size)), np.empty((size, size))
    for row in range(size):
        for column in range(size):
            centre[row, column] = 0.5 * (slope[row, column, 0] + slope[row, column, 1])
    if not solve_into(centre, inverse):
        return True
    for row in range(size):
        _component(box, at, value, slope, inverse, row)
    return not inverted(box, size)


@compiled
def _component(box: Box, at: Array, value: Array, slope: Array, inverse: Array, row: int) -> None:
    """One row of C F(b0, lambda0) + C S (x - x0) = 0, solved for its own unknown."""
    size = len(at)
    rest = (0.0, 0.0)
    own = (1.0, 1.0)
    for r in range(size):
        rest = sub(rest, mul((inverse[row, r], inverse[row, r]), (value[r, 0], value[r, 1])))
    for column in range(size):
        entry = (0.0, 0.0)
        for r in range(size):
            if slope[r, column, 0] != 0.0 or slope[r, column, 1] != 0.0:
                entry = add(
                    entry, mul((inverse[row, r], inverse[row, r]), (slope[r, column, 0], slope[r, column, 1]))
                )
        if column == row:
            own = entry
        else:
            step = sub((box[column, 0], box[column, 1]), (at[column], at[column]))
            rest = sub(rest, mul(entry, step))
    if own[0] <= 0.0 <= own[1]:
        return
    moved = add((at[row], at[row]), divide(rest, own))
    lower(box, row, moved[0])
    upper(box, row, moved[1])
