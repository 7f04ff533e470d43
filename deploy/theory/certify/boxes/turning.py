"""Second-order contractors: where turning some robots lets phi fall, the critical point is no minimum.

A direction v with v . grad beta_q = 0 for every stiff contact has
v^T H v / 2 = sum_i |v_i|^2 - sum lambda_ij |v_ij|^2 + sum lambda_0i |v_i|^2 - 2 (y . v)^2 / gamma
+ sum_q (lambda_q / beta_q) (grad beta_q . v)^2 / 2, with H = gamma kappa Hess(log phi^) at critical points.
"""

from __future__ import annotations

import numpy as np

from deploy.theory.certify.boxes.intervals import Interval, add, compiled, down, mul, square, sub, up
from deploy.theory.certify.boxes.scene import Box, Derived, Scene, lower, upper


@compiled
def stiffness(box: Box, out: Derived, n: int, q: int) -> float:
    """Upper bound of lambda_q / beta_q, which is also kappa gamma / beta_q^2; may be +inf."""
    beta = out.beta[q, 0]
    if beta <= 0.0:
        return np.inf
    return min(up(box[n + q, 1] / beta), up(up(out.total[1, 1] / beta) / beta))  # beta^2 may underflow


@compiled
def contract_rotation(scene: Scene, box: Box) -> bool:
    """v = J b, the whole fleet turns: v^T H v / 2 = sum b_i . g_i, which a minimum has non-negative."""
    n = len(scene.goals)
    total = 0.0
    for row in range(n):
        total = up(total + _reach(scene, box, row))
    if total < 0.0:
        return False
    for row in range(n):
        goal, rest = scene.goals[row], 0.0
        for other in range(n):
            if other != row:
                rest = up(rest + _reach(scene, box, other))
        if goal > 0.0:
            lower(box, row, down(-rest / goal))
        elif goal < 0.0:
            upper(box, row, up(rest / -goal))
        if box[row, 0] > box[row, 1]:
            return False
    return True


@compiled
def _reach(scene: Scene, box: Box, row: int) -> float:
    goal = scene.goals[row]
    return up(goal * box[row, 1]) if goal > 0.0 else up(goal * box[row, 0])


@compiled
def circles(scene: Scene, box: Box, out: Derived) -> bool:
    """Whether a robot that circles another, or the centre, has negative curvature all over the box."""
    for q in range(len(scene.first)):
        if circle(scene, box, out, q, scene.first[q]) < 0.0:
            return True
        if scene.second[q] >= 0 and circle(scene, box, out, q, scene.second[q]) < 0.0:
            return True
    return False


@compiled
def circle(scene: Scene, box: Box, out: Derived, q: int, robot: int) -> float:
    """Upper bound of v^T H v / 2 for v = J d_q on one robot alone, where grad beta_q . v = 0 exactly.

    +inf, or anything above 0, where it is of no use.
    """
    n, gain, bend = len(scene.goals), 1.0, 0.0
    for r in range(len(scene.first)):
        if scene.first[r] == robot or scene.second[r] == robot:
            gain = up(gain - box[n + r, 0]) if scene.second[r] >= 0 else up(gain + box[n + r, 1])
    if gain >= 0.0:
        return np.inf
    for r in range(len(scene.first)):
        if r != q and (scene.first[r] == robot or scene.second[r] == robot):
            cross = square(
                sub(mul(_apart(out, q, 0), _apart(out, r, 1)), mul(_apart(out, q, 1), _apart(out, r, 0)))
            )
            if cross[1] > 0.0:
                bend = up(bend + up(2.0 * up(stiffness(box, out, n, r) * cross[1])))
    far = add(_square(out, q, 0), _square(out, q, 1))
    return up(up(gain * far[0]) + bend)


@compiled
def _apart(out: Derived, q: int, a: int) -> Interval:
    return out.apart[q, a, 0], out.apart[q, a, 1]


@compiled
def _square(out: Derived, q: int, a: int) -> Interval:
    return square(_apart(out, q, a))
