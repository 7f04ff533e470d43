"""Branch and bound, depth first: every box is emptied, certified by curvature, or halved."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from deploy.certify.curvature import falls
from deploy.certify.distances import contract_distances, enclose
from deploy.certify.forces import contract_balance, contract_torque
from deploy.certify.kernel import compiled
from deploy.certify.scene import Box, Derived, Scene
from deploy.certify.turning import circles, contract_rotation
from deploy.certify.work import contract_work, enclose_work

EMPTY, FALLS = 255, 254  # leaves of the branching; every other byte is the row that was halved

_ROUNDS = 8
_PROGRESS = 0.9  # contract again while a width falls below this share


@compiled
def contract(scene: Scene, box: Box, out: Derived) -> bool:
    """First-order contractors until they yield little. False: no critical point but the goal in the box."""
    sets = 1 << (len(scene.goals) // 2)
    for _ in range(_ROUNDS):
        before = _size(scene, box)
        if not enclose(scene, box, out) or not contract_distances(scene, box, out):
            return False
        enclose_work(scene, box, out)
        if not contract_work(scene, box, out):
            return False
        for members in range(1, sets):
            if not contract_balance(scene, box, out, members) or not contract_torque(scene, box, members):
                return False
        if not _size(scene, box) < _PROGRESS * before:
            break
    return enclose(scene, box, out)


@compiled
def _size(scene: Scene, box: Box) -> float:
    """Something that falls when a contraction was worth it."""
    total = 0.0
    for row in range(len(box) - 1):
        width = box[row, 1] - box[row, 0]
        total += width if row < len(scene.goals) else 0.1 * min(width, 10.0) * (box[0, 1] - box[0, 0])
    return total


@compiled
def settle(scene: Scene, box: Box, out: Derived, share: float) -> int:
    """Contract a box: EMPTY, FALLS, or -1 when neither could be shown."""
    if not contract_rotation(scene, box) or not contract(scene, box, out):
        return EMPTY
    if circles(scene, box, out) or falls(scene, box, out, share):
        return FALLS
    return -1


@compiled
def widest(scene: Scene, box: Box, tune: NDArray[np.float64]) -> int:
    """The row to halve."""
    best, row, last = 0.0, -1, len(box) - 1
    unit = np.sqrt(scene.contact[0, 0])
    for candidate in range(len(scene.goals)):
        width = (box[candidate, 1] - box[candidate, 0]) / unit
        if width > best:
            best, row = width, candidate
    spread = (box[last, 1] - box[last, 0]) / tune[2]
    if tune[1] * spread > best:
        row = last
    return row


@compiled
def advance(
    scene: Scene,
    stack: NDArray[np.float64],
    depth: NDArray[np.int64],
    height: int,
    out: Derived,
    tape: NDArray[np.uint8],
    tune: NDArray[np.float64],
    counts: NDArray[np.float64],
) -> tuple[int, int]:
    """Work on the stack's top until it is empty or the tape is full: (height left, tape written)."""
    written = 0
    while height > 0 and written < len(tape) and height + 1 < len(stack):
        box = stack[height - 1]
        level = depth[height - 1]
        code = settle(scene, box, out, tune[0])
        counts[3] += 1
        if code >= 0:
            tape[written] = code
            counts[0 if code == EMPTY else 1] += 1
            counts[2] += 0.5**level
            height -= 1
        else:
            row = widest(scene, box, tune)
            tape[written] = row
            half = 0.5 * (box[row, 0] + box[row, 1])
            stack[height] = box
            stack[height - 1, row, 0] = half
            stack[height, row, 1] = half
            depth[height - 1] = depth[height] = level + 1
            height += 1
        written += 1
    return height, written
