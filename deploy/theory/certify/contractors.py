"""Contractors: reductions of a box by distances, balance and virtual work.

Distances: beta_q >= 0, beta_q = |d_q|^2 - rho_q^2, lambda_q beta_q = kappa gamma.

Balance, for robots and sets of robots: y_i = sum_j lambda_ij d_ij - lambda_0i b_i. Summed over a set C of
robots, forces inside C cancel, and so do their torques: sum_C y = sum over pairs (i in C, j not) lambda_ij
d_ij - sum_C lambda_0i b_i, and sum_C b_i x g_i = sum over the same pairs lambda_ij b_i x b_j.

Virtual work along y: sum_q lambda_q w_q = gamma and sum_q w_q / beta_q = k. w_q = y . grad beta_q / 2 is d_ij
. y_ij for a pair and -b_i . y_i for a wall. Completing the square, w_ij = |d_ij - g_ij / 2|^2 - |g_ij|^2 / 4,
an exact range over a box of d_ij.
"""

from __future__ import annotations

import numpy as np

from deploy.theory.certify.boxes import (
    Box,
    Derived,
    Interval,
    Scene,
    add,
    compiled,
    divide,
    ends,
    inverted,
    mul,
    narrow,
    quotient,
    root_above,
    root_below,
    square,
    sub,
    up,
    weigh,
)


@compiled
def enclose(scene: Scene, box: Box, out: Derived) -> bool:
    """Derive y, gamma, s, d_q, beta_q from b and kappa; contract lambda. False: the box is empty."""
    n, last = len(scene.goals), len(box) - 1
    gamma = (0.0, 0.0)
    for row in range(n):
        y = sub(ends(box, row), (scene.goals[row], scene.goals[row]))
        out.pull[row] = y
        gamma = add(gamma, square(y))
    s = mul(ends(box, last), (max(0.0, gamma[0]), gamma[1]))
    out.total[0] = max(0.0, gamma[0]), gamma[1]
    out.total[1] = max(0.0, s[0]), s[1]
    for q in range(len(scene.first)):
        _separation(scene, box, out, q)
        if out.beta[q, 0] > out.beta[q, 1]:
            return False
        if not narrow(box, n + q, quotient(ends(out.total, 1), ends(out.beta, q))):
            return False
        if not narrow(out.beta, q, quotient(ends(out.total, 1), ends(box, n + q))):
            return False
    return True


@compiled
def _separation(scene: Scene, box: Box, out: Derived, q: int) -> None:
    i, j = scene.first[q], scene.second[q]
    contact = ends(scene.contact, q)
    for a in range(2):
        own = ends(box, 2 * i + a)
        out.apart[q, a] = own if j < 0 else sub(own, ends(box, 2 * j + a))
    far = add(square(ends(out.apart[q], 0)), square(ends(out.apart[q], 1)))
    beta = sub(contact, far) if j < 0 else sub(far, contact)
    out.beta[q] = max(0.0, beta[0]), beta[1]


@compiled
def contract_distances(scene: Scene, box: Box, out: Derived) -> bool:
    """Contract b to where every beta_q can have the values that it was enclosed in."""
    for q in range(len(scene.first)):
        i, j = scene.first[q], scene.second[q]
        contact = ends(scene.contact, q)
        beta = ends(out.beta, q)
        far = sub(contact, beta) if j < 0 else add(contact, beta)
        for a in range(2):
            other = square(ends(out.apart[q], 1 - a))
            rest = sub(far, other)
            if rest[1] < 0.0:
                return False
            most, least = root_above(rest[1]), root_below(rest[0])
            low, high = max(out.apart[q, a, 0], -most), min(out.apart[q, a, 1], most)
            if low > -least:
                low = max(low, least)
            if high < least:
                high = min(high, -least)
            if low > high:
                return False
            out.apart[q, a] = low, high
            one, two = 2 * i + a, 2 * j + a
            if j < 0:
                narrow(box, one, (low, high))
            else:
                narrow(box, one, add(ends(box, two), (low, high)))
                narrow(box, two, sub(ends(box, one), (low, high)))
    return not inverted(box, len(scene.goals))


@compiled
def _sign(scene: Scene, members: int, q: int) -> int:
    """Sign of lambda_q d_q as a force on the set; 0 if it does not act, or acts inside."""
    i, j = scene.first[q], scene.second[q]
    if j < 0:
        return int(-((members >> i) & 1))
    return int(((members >> i) & 1) - ((members >> j) & 1))


@compiled
def _force(scene: Scene, box: Box, out: Derived, members: int, a: int, without: int) -> Interval:
    """Sum of the outside forces on the set along one axis, except factor `without`."""
    n, total = len(scene.goals), (0.0, 0.0)
    for q in range(len(scene.first)):
        sign = 0 if q == without else _sign(scene, members, q)
        if sign != 0:
            force = weigh(ends(box, n + q), ends(out.apart[q], a))
            total = add(total, force if sign > 0 else (-force[1], -force[0]))
    return total


@compiled
def contract_balance(scene: Scene, box: Box, out: Derived, members: int) -> bool:
    """Balance of the set with bit pattern `members`, both axes: contracts b and lambda."""
    n, factors = len(scene.goals), len(scene.first)
    for a in range(2):
        force = _force(scene, box, out, members, a, -1)
        pull = (0.0, 0.0)
        for i in range(n // 2):
            if (members >> i) & 1:
                pull = add(pull, ends(out.pull, 2 * i + a))
        if force[0] > pull[1] or force[1] < pull[0]:
            return False
        for i in range(n // 2):
            if (members >> i) & 1 and not _place(scene, box, out, members, force, 2 * i + a):
                return False
        for q in range(factors):
            sign = _sign(scene, members, q)
            if sign != 0 and not _weight(scene, box, out, members, pull, q, a, sign):
                return False
    return True


@compiled
def _place(scene: Scene, box: Box, out: Derived, members: int, force: Interval, row: int) -> bool:
    """Contract one coordinate: y of this robot is the force minus the others' y."""
    rest = force
    for other in range(row % 2, len(scene.goals), 2):
        if other != row and (members >> (other // 2)) & 1:
            rest = sub(rest, ends(out.pull, other))
    left = narrow(out.pull, row, rest)  # an early return would make the search 15 % slower
    return narrow(box, row, add(ends(out.pull, row), (scene.goals[row], scene.goals[row]))) and left


@compiled
def _weight(
    scene: Scene, box: Box, out: Derived, members: int, pull: Interval, q: int, a: int, sign: int
) -> bool:
    """Contract one lambda: its force is y minus the other forces."""
    n = len(scene.goals)
    apart = ends(out.apart[q], a)
    if apart[0] <= 0.0 <= apart[1]:
        return True
    rest = sub(pull, _force(scene, box, out, members, a, q))
    return narrow(box, n + q, divide(rest if sign > 0 else (-rest[1], -rest[0]), apart))


@compiled
def contract_torque(scene: Scene, box: Box, members: int) -> bool:
    """Torque about the origin on a set: sum_C b_i x g_i = sum over crossing pairs lambda_ij b_i x b_j."""
    n, p = len(scene.goals), len(scene.goals) // 2
    torque = (0.0, 0.0)
    for q in range(len(scene.first) - p):
        i, j = scene.first[q], scene.second[q]
        sign = _sign(scene, members, q)
        if sign != 0:
            cross = sub(
                mul(ends(box, 2 * i), ends(box, 2 * j + 1)), mul(ends(box, 2 * i + 1), ends(box, 2 * j))
            )
            turn = weigh(ends(box, n + q), cross)
            torque = add(torque, turn if sign > 0 else (-turn[1], -turn[0]))
    return _linear(scene, box, members, torque, True)


@compiled
def contract_rotation(scene: Scene, box: Box) -> bool:
    """v = J b, a rotation of the fleet: v^T H v / 2 = sum b_i . g_i, which is not negative at a minimum."""
    return _linear(scene, box, -1, (0.0, np.inf), False)


@compiled
def _linear(scene: Scene, box: Box, members: int, value: Interval, cross: bool) -> bool:
    """Contract b by the sum of b_i x g_i (`cross`) or b_i . g_i over the set, which is in `value`."""
    n = len(scene.goals)
    for row in range(n):
        if not (members >> (row // 2)) & 1:
            continue
        rest = value
        for other in range(n):
            if other != row and (members >> (other // 2)) & 1:
                arm = _factor(scene, other, cross)
                rest = sub(rest, mul(ends(box, other), (arm, arm)))
        factor = _factor(scene, row, cross)
        if factor == 0.0:
            if rest[0] > 0.0 or rest[1] < 0.0:
                return False
            continue
        if not narrow(box, row, divide(rest, (factor, factor))):
            return False
    return True


@compiled
def _factor(scene: Scene, row: int, cross: bool) -> float:
    """Factor of a coordinate of b in b x g = b_x g_y - b_y g_x, or in b . g."""
    if cross:
        return float(scene.goals[row + 1] if row % 2 == 0 else -scene.goals[row - 1])
    return float(scene.goals[row])


@compiled
def enclose_work(scene: Scene, out: Derived) -> None:
    """Derive w_q of every factor."""
    for q in range(len(scene.first)):
        i, j = scene.first[q], scene.second[q]
        total = (0.0, 0.0)
        for a in range(2):
            goal = (scene.goals[2 * i + a], scene.goals[2 * i + a])
            if j >= 0:
                goal = sub(goal, (scene.goals[2 * j + a], scene.goals[2 * j + a]))
            half = (0.5 * goal[0], 0.5 * goal[1])
            moved = square(sub(ends(out.apart[q], a), half))
            total = add(total, sub(moved, square(half)))
        out.work[q] = total if j >= 0 else (-total[1], -total[0])


@compiled
def contract_work(scene: Scene, box: Box, out: Derived) -> bool:
    """Contract lambda by sum lambda_q w_q = gamma; also False if k = sum w_q / beta_q cannot be reached."""
    n, factors, last = len(scene.goals), len(scene.first), len(box) - 1
    k = 0.0
    for q in range(factors):
        most = out.work[q, 1]
        beta = out.beta[q, 0] if most > 0.0 else out.beta[q, 1]
        k = np.inf if most > 0.0 and beta == 0.0 else up(k + up(most / beta))
    if up(k * box[last, 1]) < 1.0:
        return False
    for q in range(factors):
        rest = ends(out.total, 0)
        for r in range(factors):
            if r != q:
                rest = sub(rest, _share(box, out, n, r))
        work = ends(out.work, q)
        if work[0] > 0.0 or work[1] < 0.0:
            if not narrow(box, n + q, divide(rest, work)):
                return False
        else:
            term = _share(box, out, n, q)
            if term[0] > rest[1] or term[1] < rest[0]:
                return False
    return True


@compiled
def _share(box: Box, out: Derived, n: int, q: int) -> Interval:
    return weigh(ends(box, n + q), ends(out.work, q))
