"""Contractors of virtual work along y: sum_q lambda_q w_q = gamma and sum_q w_q / beta_q = k.

w_q = y . grad beta_q / 2 is d_ij . y_ij for a pair and -b_i . y_i for a wall. Completing the square,
w_ij = |d_ij - g_ij / 2|^2 - |g_ij|^2 / 4, an exact range over a box of d_ij.
"""

from __future__ import annotations

import numpy as np

from deploy.theory.certify.boxes.intervals import Interval, add, divide, square, sub, up, weigh
from deploy.theory.certify.boxes.kernel import compiled
from deploy.theory.certify.boxes.scene import Box, Derived, Scene, lower, upper


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
            moved = square(sub((out.apart[q, a, 0], out.apart[q, a, 1]), half))
            total = add(total, sub(moved, square(half)))
        out.work[q] = total if j >= 0 else (-total[1], -total[0])


@compiled
def contract_work(scene: Scene, box: Box, out: Derived) -> bool:
    """Contract lambda by sum lambda_q w_q = gamma; False also where k = sum w_q / beta_q is out of reach."""
    n, factors, last = len(scene.goals), len(scene.first), len(box) - 1
    k = 0.0
    for q in range(factors):
        most = out.work[q, 1]
        beta = out.beta[q, 0] if most > 0.0 else out.beta[q, 1]
        k = np.inf if most > 0.0 and beta == 0.0 else up(k + up(most / beta))
    if up(k * box[last, 1]) < 1.0:
        return False
    gamma = (out.total[0, 0], out.total[0, 1])
    for q in range(factors):
        rest = gamma
        for r in range(factors):
            if r != q:
                rest = sub(rest, _term(box, out, n, r))
        work = (out.work[q, 0], out.work[q, 1])
        if work[0] > 0.0 or work[1] < 0.0:
            weight = divide(rest, work)
            lower(box, n + q, weight[0])
            upper(box, n + q, weight[1])
            if box[n + q, 0] > box[n + q, 1]:
                return False
        else:
            term = _term(box, out, n, q)
            if term[0] > rest[1] or term[1] < rest[0]:
                return False
    return True


@compiled
def _term(box: Box, out: Derived, n: int, q: int) -> Interval:
    return weigh((box[n + q, 0], box[n + q, 1]), (out.work[q, 0], out.work[q, 1]))
