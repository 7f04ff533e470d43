"""Contractors of balance: y_i = sum_j lambda_ij d_ij - lambda_0i b_i for robots and sets of robots.

Summed over a set C of robots, forces inside C cancel, and so do their torques:
sum_C y = sum over pairs (i in C, j not) lambda_ij d_ij - sum_C lambda_0i b_i, and
sum_C b_i x g_i = sum over the same pairs lambda_ij b_i x b_j.
"""

from __future__ import annotations

from deploy.theory.certify.boxes.intervals import Interval, add, divide, mul, sub, weigh
from deploy.theory.certify.boxes.kernel import compiled
from deploy.theory.certify.boxes.scene import Box, Derived, Scene, lower, upper


@compiled
def _inside(members: int, robot: int) -> int:
    return 1 if (members >> robot) & 1 else 0


@compiled
def _sign(scene: Scene, members: int, q: int) -> int:
    """With which sign lambda_q d_q acts on the set: 0 when it does not, or acts inside."""
    i, j = scene.first[q], scene.second[q]
    if j < 0:
        return -_inside(members, i)
    return _inside(members, i) - _inside(members, j)


@compiled
def _term(box: Box, out: Derived, n: int, q: int, a: int, sign: int) -> Interval:
    force = weigh((box[n + q, 0], box[n + q, 1]), (out.apart[q, a, 0], out.apart[q, a, 1]))
    return force if sign > 0 else (-force[1], -force[0])


@compiled
def _force(scene: Scene, box: Box, out: Derived, members: int, a: int, without: int) -> Interval:
    """Sum of what acts on the set from outside along one axis, leaving out one factor."""
    n, total = len(scene.goals), (0.0, 0.0)
    for q in range(len(scene.first)):
        sign = 0 if q == without else _sign(scene, members, q)
        if sign != 0:
            total = add(total, _term(box, out, n, q, a, sign))
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
                pull = add(pull, (out.pull[2 * i + a, 0], out.pull[2 * i + a, 1]))
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
    """Contract one coordinate: y of this robot is the force less the others' y."""
    rest = force
    for other in range(row % 2, len(scene.goals), 2):
        if other != row and (members >> (other // 2)) & 1:
            rest = sub(rest, (out.pull[other, 0], out.pull[other, 1]))
    lower(out.pull, row, rest[0])
    upper(out.pull, row, rest[1])
    b = add((out.pull[row, 0], out.pull[row, 1]), (scene.goals[row], scene.goals[row]))
    lower(box, row, b[0])
    upper(box, row, b[1])
    return bool(out.pull[row, 0] <= out.pull[row, 1] and box[row, 0] <= box[row, 1])


@compiled
def _weight(
    scene: Scene, box: Box, out: Derived, members: int, pull: Interval, q: int, a: int, sign: int
) -> bool:
    """Contract one lambda: its force is y less the other forces."""
    n = len(scene.goals)
    apart = (out.apart[q, a, 0], out.apart[q, a, 1])
    if apart[0] <= 0.0 <= apart[1]:
        return True
    rest = sub(pull, _force(scene, box, out, members, a, q))
    weight = divide(rest if sign > 0 else (-rest[1], -rest[0]), apart)
    lower(box, n + q, weight[0])
    upper(box, n + q, weight[1])
    return bool(box[n + q, 0] <= box[n + q, 1])


@compiled
def _row(box: Box, row: int) -> Interval:
    return box[row, 0], box[row, 1]


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
                mul(_row(box, 2 * i), _row(box, 2 * j + 1)), mul(_row(box, 2 * i + 1), _row(box, 2 * j))
            )
            turn = weigh(_row(box, n + q), cross)
            torque = add(torque, turn if sign > 0 else (-turn[1], -turn[0]))
    return _linear(scene, box, members, torque)


@compiled
def _linear(scene: Scene, box: Box, members: int, value: Interval) -> bool:
    """Contract b by sum_C b_i x g_i in `value`, which is linear in b."""
    n = len(scene.goals)
    for row in range(n):
        if not (members >> (row // 2)) & 1:
            continue
        rest = value
        for other in range(n):
            if other != row and (members >> (other // 2)) & 1:
                rest = sub(rest, _moment(scene, box, other))
        arm = scene.goals[row + 1] if row % 2 == 0 else -scene.goals[row - 1]
        if arm == 0.0:
            if rest[0] > 0.0 or rest[1] < 0.0:
                return False
            continue
        b = divide(rest, (arm, arm))
        lower(box, row, b[0])
        upper(box, row, b[1])
        if box[row, 0] > box[row, 1]:
            return False
    return True


@compiled
def _moment(scene: Scene, box: Box, row: int) -> Interval:
    """One term of b x g: b_x g_y or -b_y g_x."""
    arm = scene.goals[row + 1] if row % 2 == 0 else -scene.goals[row - 1]
    return mul(_row(box, row), (arm, arm))
