"""Interval Newton and the curvature test in Arb; numpy makes proposals, balls prove them."""

from __future__ import annotations

import numpy as np
from flint import arb, arb_mat

from deploy.theory.certify.conditions import (
    INFINITE,
    ZERO,
    BoxConditions,
    Ends,
    add,
    ball,
    ends,
    middle,
    mul,
    narrow,
    square,
    sub,
)
from protocol.arrays import Reals

_STIFF, _SOFT = 1e4, 0.1  # heuristic choices


def newton(box: BoxConditions) -> bool:
    """Krawczyk's operator on (b, lambda), if all lambda are bounded. False: no solution in the box."""
    size = len(box.rows) - 1
    if any(not row[1] < INFINITE for row in box.rows[:-1]):
        return True
    at = [arb(middle(row)) for row in box.rows[:-1]]
    value, slope = _system(box, at)
    centre = np.array([float(x.mid()) for x in slope.entries()]).reshape(size, size)
    try:
        inverse = arb_mat(size, size, np.linalg.inv(centre).ravel().tolist())
    except (np.linalg.LinAlgError, ValueError):
        return True
    product = inverse * slope
    shift = inverse * value
    steps = [sub(box.b(row), (at[row], at[row])) for row in range(size)]
    for row in range(size):
        own = product[row, row]
        if not (own > 0 or own < 0):
            continue
        rest = -shift[row, 0]
        for column in range(size):
            if column != row:
                rest -= product[row, column] * ball(steps[column])
        if not narrow(box.rows[row], ends(at[row] + rest / own)):
            return False
        steps[row] = sub(box.b(row), (at[row], at[row]))
    return True


def _system(box: BoxConditions, at: list[arb]) -> tuple[arb_mat, arb_mat]:
    """F at a point for all kappa of the box, and slopes from there to any other point of the box."""
    n, size = box.n, len(at)
    kappa = ball((box.rows[-1][0], box.rows[-1][1]))
    value = [at[row] - box.g[row] for row in range(n)]
    target = kappa * sum((y * y for y in value), ZERO)
    slope = [[ZERO] * size for _ in range(size)]
    for row in range(n):
        slope[row][row] = arb(1)
        both = kappa * (value[row] + ball(box.y[row]))
        for q in range(len(box.factors)):
            slope[n + q][row] = -both
    for q, (i, j) in enumerate(box.factors):
        weight, far = at[n + q], ZERO
        for a in (0, 1):
            one, two = 2 * i + a, 2 * j + a
            there = at[one] if j < 0 else at[one] - at[two]
            here = ball(box.d[q][a])
            far += there * there
            sign = -1 if j >= 0 else 1
            value[one] += sign * weight * there
            slope[one][one] += sign * weight
            slope[one][n + q] = sign * here
            slope[n + q][one] -= sign * weight * (here + there)
            if j >= 0:
                value[two] += weight * there
                slope[two][two] -= weight
                slope[one][two] += weight
                slope[two][one] += weight
                slope[two][n + q] = here
                slope[n + q][two] -= weight * (here + there)
        contact = ball(box.contact[q])
        value.append(weight * (contact - far if j < 0 else far - contact) - target)
        slope[n + q][n + q] = ball(box.beta[q])
    return arb_mat(size, 1, value), arb_mat(size, size, [x for row in slope for x in row])


def descends(box: BoxConditions) -> bool:
    """Whether a direction, orthogonal to stiff contacts, has negative curvature all over the box."""
    stiff = _stiff(box)
    v = _proposal(box, stiff)
    if v is None:
        return False
    field = _field(box, stiff, v)
    return field is not None and _form(box, stiff, field) < 0


def _stiff(box: BoxConditions) -> list[int]:
    found: list[int] = []
    for q, (i, j) in enumerate(box.factors):
        rows = [2 * i, 2 * i + 1] + ([2 * j, 2 * j + 1] if j >= 0 else [])
        width = max(float((box.rows[row][1] - box.rows[row][0]).mid()) for row in rows)
        bend = box.stiffness(q)
        if len(found) < box.n - 1 and (not bend.is_finite() or float(bend.mid()) * width**2 > _SOFT):
            found.append(q)
    return found


def _gradient(box: BoxConditions, q: int) -> Reals:
    row = np.zeros(box.n)
    i, j = box.factors[q]
    own = np.array([middle(box.rows[2 * i + a]) for a in (0, 1)])
    if j < 0:
        row[2 * i : 2 * i + 2] = -own
    else:
        apart = own - np.array([middle(box.rows[2 * j + a]) for a in (0, 1)])
        row[2 * i : 2 * i + 2] = apart
        row[2 * j : 2 * j + 2] = -apart
    return row


@np.errstate(all="ignore")
def _proposal(box: BoxConditions, stiff: list[int]) -> Reals | None:
    """The lowest eigenvector of the midpoint's form with stiffer contacts; None if it is positive, or too
    large to be known."""
    m, weights = np.eye(box.p), []
    for q, (i, j) in enumerate(box.factors):
        row = box.rows[box.n + q]
        weights.append(middle(row) if row[1] < INFINITE else 2.0 * float(row[0].mid()) + 1.0)
        if j < 0:
            m[i, i] += weights[q]
        else:
            m[[i, j], [i, j]] -= weights[q]
            m[[i, j], [j, i]] += weights[q]
    form = np.kron(m, np.eye(2))
    for q, weight in enumerate(weights):
        gradient = _gradient(box, q)
        size = float(gradient @ gradient)
        if size > 0.0:
            most = _STIFF * max(1.0, *weights) / size
            beta = max(middle(box.beta[q]), 1e-12 * size)
            form += (most if q in stiff else min(2.0 * weight / beta, most)) * np.outer(gradient, gradient)
    if not np.isfinite(form).all():
        return None
    values, vectors = np.linalg.eigh(form)
    return np.asarray(vectors[:, 0]) if values[0] < 0.0 else None


def _along(box: BoxConditions, q: int, v: list[Ends]) -> Ends:
    i, j = box.factors[q]
    total = (ZERO, ZERO)
    for a in (0, 1):
        turn = v[2 * i + a] if j < 0 else sub(v[2 * i + a], v[2 * j + a])
        total = add(total, mul(box.d[q][a], turn))
    return total if j >= 0 else (-total[1], -total[0])


def _field(box: BoxConditions, stiff: list[int], v: Reals) -> list[Ends] | None:
    """v - W z, orthogonal to the stiff gradients for every b of the box."""
    fixed = [(arb(x), arb(x)) for x in v.tolist()]
    if not stiff:
        return fixed
    basis = [_gradient(box, q).tolist() for q in stiff]
    columns = [[(arb(x), arb(x)) for x in row] for row in basis]
    matrix = [ball(_along(box, q, column)) for q in stiff for column in columns]
    right = [ball(_along(box, q, fixed)) for q in stiff]
    try:
        z = arb_mat(len(stiff), len(stiff), matrix).solve(arb_mat(len(stiff), 1, right))
    except ZeroDivisionError:
        return None
    spread = [z[r, 0] for r in range(len(stiff))]
    return [
        ends(fixed[row][0] - sum((basis[r][row] * s for r, s in enumerate(spread)), ZERO))
        for row in range(box.n)
    ]


def _form(box: BoxConditions, stiff: list[int], v: list[Ends]) -> arb:
    total = ZERO
    for x in v:
        total += square(x)[1]
    for q, (i, j) in enumerate(box.factors):
        turn = [v[2 * i + a] if j < 0 else sub(v[2 * i + a], v[2 * j + a]) for a in (0, 1)]
        speed = add(square(turn[0]), square(turn[1]))
        low, high = box.weight(q)
        total += high * speed[1] if j < 0 else -low * speed[0]
        if q not in stiff:
            total += 2 * box.stiffness(q) * square(_along(box, q, v))[1]
    return total
