"""Second-order test: if phi decreases along one direction all over a box, no critical point in it is a
minimum.

A direction v with v . grad beta_q = 0 for every stiff contact has v^T H v / 2 = sum_i |v_i|^2 - sum lambda_ij
|v_ij|^2 + sum lambda_0i |v_i|^2 - 2 (y . v)^2 / gamma + sum_q (lambda_q / beta_q) (grad beta_q . v)^2 / 2,
with H = gamma kappa Hess(log phi^) at critical points.

A rotation of the whole fleet is such a direction. In general the midpoint's most negative eigenvector v is
corrected to v - W z with interval z so that it is exactly orthogonal to grad beta_q of every stiff q,
whatever b in the box: z solves (A W) z = A v, A the rows grad beta_q / 2 over the box. The quadratic form is
then bounded from above over box and z.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from deploy.theory.certify.boxes import (
    Box,
    Derived,
    Interval,
    Scene,
    add,
    compiled,
    down,
    ends,
    lowest,
    middle,
    mul,
    solve_into,
    square,
    sub,
    up,
)
from protocol.arrays import Reals


@compiled
def stiffness(box: Box, out: Derived, n: int, q: int) -> float:
    """Upper bound of lambda_q / beta_q, which is also kappa gamma / beta_q^2; may be +inf."""
    beta = out.beta[q, 0]
    if beta <= 0.0:
        return np.inf
    return min(up(box[n + q, 1] / beta), up(up(out.total[1, 1] / beta) / beta))  # beta^2 may underflow


# Heuristic choices, which do not affect the validity of a proof.
_FAR = 0.9  # |I - C A W| from which z is unknown; any number below 1
_STIFF = 1e4  # weight of a stiff contact in the search of the direction
_SOFT = 0.1  # largest addition to the form of a contact that is not corrected


@compiled
def falls(scene: Scene, box: Box, out: Derived) -> bool:
    """Whether negative curvature is proven for the whole box."""
    n, factors = len(scene.goals), len(scene.first)
    chosen = np.zeros(factors, dtype=np.int64)
    count = 0
    for q in range(factors):
        if stiffness(box, out, n, q) * _width(scene, box, q) ** 2 > _SOFT and count < n - 1:
            chosen[count] = q
            count += 1
    stiff = chosen[:count]
    v = np.zeros(n)
    if not _direction(scene, box, out, stiff, v):
        return False
    field = np.empty((n, 2))
    if not corrected(scene, box, out, stiff, v, field):
        return False
    return form(scene, box, out, stiff, field) < 0.0


@compiled
def _width(scene: Scene, box: Box, q: int) -> float:
    i, j = scene.first[q], scene.second[q]
    width = 0.0
    for a in range(2):
        width = max(width, box[2 * i + a, 1] - box[2 * i + a, 0])
        if j >= 0:
            width = max(width, box[2 * j + a, 1] - box[2 * j + a, 0])
    return width


@compiled
def _weight(box: Box, row: int) -> float:
    return middle(ends(box, row)) if box[row, 1] < np.inf else 2.0 * box[row, 0] + 1.0


@compiled
def _gradient(scene: Scene, box: Box, q: int, row: Reals) -> None:
    i, j = scene.first[q], scene.second[q]
    row[:] = 0.0
    for a in range(2):
        own = middle(ends(box, 2 * i + a))
        if j < 0:
            row[2 * i + a] = -own
        else:
            other = middle(ends(box, 2 * j + a))
            row[2 * i + a] = own - other
            row[2 * j + a] = other - own


@compiled
def _direction(scene: Scene, box: Box, out: Derived, stiff: NDArray[np.int64], v: Reals) -> bool:
    """The most negative eigenvector of the midpoint's H / 2, with stiff contacts made much stiffer."""
    n, factors = len(scene.goals), len(scene.first)
    form, row, largest = np.eye(n), np.empty(n), 1.0
    for q in range(factors):
        i, j = scene.first[q], scene.second[q]
        weight = _weight(box, n + q)
        largest = max(largest, weight)
        for a in range(2):
            if j < 0:
                form[2 * i + a, 2 * i + a] += weight
            else:
                form[2 * i + a, 2 * i + a] -= weight
                form[2 * j + a, 2 * j + a] -= weight
                form[2 * i + a, 2 * j + a] += weight
                form[2 * j + a, 2 * i + a] += weight
    for q in range(factors):
        _gradient(scene, box, q, row)
        size = (row * row).sum()
        if size == 0.0:
            continue
        most = _STIFF * largest / size
        bend = 2.0 * _weight(box, n + q) / max(middle(ends(out.beta, q)), 1e-12 * size)
        bend = most if (stiff == q).any() else min(bend, most)
        form += np.outer(bend * row, row)
    return lowest(form, v) < 0.0


@compiled
def corrected(scene: Scene, box: Box, out: Derived, stiff: NDArray[np.int64], v: Reals, field: Reals) -> bool:
    """Enclose v - W z, W the midpoint's gradients; False if z cannot be enclosed."""
    n, count = len(scene.goals), len(stiff)
    for row in range(n):
        field[row] = v[row], v[row]
    if count == 0:
        return True
    basis, gram = np.empty((count, n)), np.zeros((count, count))
    for r in range(count):
        _gradient(scene, box, stiff[r], basis[r])
        for c in range(r + 1):
            for row in range(n):
                gram[r, c] += basis[r, row] * basis[c, row]
            gram[c, r] = gram[r, c]
    inverse = np.empty((count, count))
    if not solve_into(gram, inverse):
        return False
    spread = np.empty((count, 2))
    if not _enclose_solution(scene, out, stiff, v, basis, inverse, spread):
        return False
    for row in range(n):
        value = (v[row], v[row])
        for r in range(count):
            value = sub(value, mul((basis[r, row], basis[r, row]), ends(spread, r)))
        field[row] = value
    return True


@compiled
def _along(scene: Scene, out: Derived, q: int, v: Reals) -> Interval:
    """(grad beta_q / 2) . v over the box, for a fixed v."""
    i, j = scene.first[q], scene.second[q]
    total = (0.0, 0.0)
    for a in range(2):
        turn = (v[2 * i + a], v[2 * i + a])
        if j >= 0:
            turn = sub(turn, (v[2 * j + a], v[2 * j + a]))
        total = add(total, mul(ends(out.apart[q], a), turn))
    return total if j >= 0 else (-total[1], -total[0])


@compiled
def _enclose_solution(
    scene: Scene,
    out: Derived,
    stiff: NDArray[np.int64],
    v: Reals,
    basis: Reals,
    inverse: Reals,
    spread: Reals,
) -> bool:
    """Enclose every z with (A W) z = A v, by C close to (A W)^-1 and |I - C A W| <= e < 1, maximum norm."""
    count = len(stiff)
    right = np.empty((count, 2))
    matrix = np.empty((count, count, 2))
    for r in range(count):
        right[r] = _along(scene, out, stiff[r], v)
        for c in range(count):
            matrix[r, c] = _along(scene, out, stiff[r], basis[c])
    excess, reach = 0.0, 0.0
    for r in range(count):
        value, off = (0.0, 0.0), 0.0
        for c in range(count):
            value = add(value, mul((inverse[r, c], inverse[r, c]), ends(right, c)))
            entry = (-1.0, -1.0) if r == c else (0.0, 0.0)
            for k in range(count):
                entry = add(entry, mul((inverse[r, k], inverse[r, k]), ends(matrix[k], c)))
            off = up(off + max(abs(entry[0]), abs(entry[1])))
        spread[r] = value
        if not off < _FAR:  # also nan
            return False
        excess = max(excess, off)
        reach = max(reach, abs(value[0]), abs(value[1]))
    # z = C A v + (I - C A W) z, hence |z| <= reach / (1 - excess) and |z - C A v| <= excess |z|.
    error = up(excess * up(reach / down(1.0 - excess)))
    for r in range(count):
        spread[r, 0] = down(spread[r, 0] - error)
        spread[r, 1] = up(spread[r, 1] + error)
    return True


@compiled
def form(scene: Scene, box: Box, out: Derived, stiff: NDArray[np.int64], field: Reals) -> float:
    """Upper bound of v^T H v / 2 over the box, for every v in `field` orthogonal to the stiff gradients."""
    n, factors = len(scene.goals), len(scene.first)
    total = 0.0
    for row in range(n):
        total = up(total + square(ends(field, row))[1])
    for q in range(factors):
        i, j = scene.first[q], scene.second[q]
        speed, along = (0.0, 0.0), (0.0, 0.0)
        for a in range(2):
            turn = ends(field, 2 * i + a)
            if j >= 0:
                turn = sub(turn, ends(field, 2 * j + a))
            speed = add(speed, square(turn))
            along = add(along, mul(ends(out.apart[q], a), turn))
        if j < 0:
            total = up(total + up(box[n + q, 1] * speed[1]))
        else:
            total = up(total - down(box[n + q, 0] * max(0.0, speed[0])))
        bend = square(along)[1]
        if bend > 0.0 and not (stiff == q).any():
            total = up(total + up(2.0 * up(stiffness(box, out, n, q) * bend)))
    return total
