"""Branch and bound, depth first: every box is emptied, certified by curvature, or halved."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from deploy.theory.certify.boxes.contractors import (
    contract_balance,
    contract_distances,
    contract_torque,
    contract_work,
    enclose,
    enclose_work,
)
from deploy.theory.certify.boxes.curvature import falls
from deploy.theory.certify.boxes.intervals import compiled
from deploy.theory.certify.boxes.newton import contract_newton
from deploy.theory.certify.boxes.scene import Box, Derived, Scene, derived
from deploy.theory.certify.boxes.turning import circles, contract_rotation
from deploy.theory.certify.certificate import EMPTY, FALLS, Grown, Open

OPEN = -1

# Choices that measurements made; none bears on what is proven.
_ROUNDS = 8
_WORTH = 0.9  # contract again while the box shrinks below this share
_NEWTON_BELOW = 0.75  # contact distances that b may span for interval Newton to be tried
_KAPPA_WIDTH = 0.5  # contact distances that the whole range of kappa counts for when the widest row is sought
_DEEPEST = 500


def grow(scene: Scene, root: Open, kappa: float, nodes: int) -> Grown:
    """Branch from `root` for at most so many nodes; kappa: the largest of the whole search, for scale."""
    size = len(root.box)
    stack = np.empty((_DEEPEST, size, 2))
    level = np.zeros(_DEEPEST, dtype=np.int64)
    stack[0], level[0] = root.box, root.level
    tape = np.empty(nodes, dtype=np.uint8)
    height, written = _advance(scene, stack, level, derived(scene), tape, kappa)
    rest = [Open(stack[k].copy(), int(level[k])) for k in range(height - 1, -1, -1)]
    return Grown(tape[:written].tobytes(), rest)


@compiled
def _advance(
    scene: Scene,
    stack: NDArray[np.float64],
    level: NDArray[np.int64],
    out: Derived,
    tape: NDArray[np.uint8],
    kappa: float,
) -> tuple[int, int]:
    """Work on top of the stack until it is empty, or full, or the tape is: (height left, tape written)."""
    height, written = 1, 0
    while 0 < height < len(stack) and written < len(tape):
        box = stack[height - 1]
        code = settle(scene, box, out)
        if code != OPEN:
            tape[written] = code
            height -= 1
        else:
            row = widest(scene, box, kappa)
            half = 0.5 * (box[row, 0] + box[row, 1])
            stack[height] = box
            stack[height - 1, row, 0] = half
            stack[height, row, 1] = half
            level[height - 1] += 1
            level[height] = level[height - 1]
            tape[written] = row
            height += 1
        written += 1
    return height, written


@compiled
def settle(scene: Scene, box: Box, out: Derived) -> int:
    """Contract a box in place to what may be a minimum: EMPTY, FALLS, or OPEN when neither could be shown."""
    if not contract_rotation(scene, box) or not contract(scene, box, out):
        return EMPTY
    if _span(scene, box) < _NEWTON_BELOW * np.sqrt(scene.contact[0, 0]) and not (
        contract_newton(scene, box, out) and contract(scene, box, out)
    ):
        return EMPTY
    if circles(scene, box, out) or falls(scene, box, out):
        return FALLS
    return OPEN


@compiled
def contract(scene: Scene, box: Box, out: Derived) -> bool:
    """First-order contractors until they yield little. False: no critical point but the goal in the box."""
    sets = 1 << (len(scene.goals) // 2)
    for _ in range(_ROUNDS):
        before = _size(scene, box)
        if not enclose(scene, box, out) or not contract_distances(scene, box, out):
            return False
        enclose_work(scene, out)
        if not contract_work(scene, box, out):
            return False
        for members in range(1, sets):
            if not contract_balance(scene, box, out, members) or not contract_torque(scene, box, members):
                return False
        if not _size(scene, box) < _WORTH * before:
            break
    return enclose(scene, box, out)


@compiled
def _size(scene: Scene, box: Box) -> float:
    """Falls when a contraction was worth it."""
    n, total = len(scene.goals), 0.0
    for row in range(n):
        total += box[row, 1] - box[row, 0]
    for row in range(n, len(box) - 1):
        total += 0.1 * min(box[row, 1] - box[row, 0], 10.0) * (box[0, 1] - box[0, 0])
    return total


@compiled
def _span(scene: Scene, box: Box) -> float:
    """Largest width of b."""
    width = 0.0
    for row in range(len(scene.goals)):
        width = max(width, box[row, 1] - box[row, 0])
    return width


@compiled
def widest(scene: Scene, box: Box, kappa: float) -> int:
    """The row to halve: of b or, when its share of [0, kappa] is wide, kappa."""
    last = len(box) - 1
    unit = np.sqrt(scene.contact[0, 0])
    best, row = _KAPPA_WIDTH * unit * (box[last, 1] - box[last, 0]) / kappa, last
    for candidate in range(len(scene.goals)):
        if box[candidate, 1] - box[candidate, 0] > best:
            best, row = box[candidate, 1] - box[candidate, 0], candidate
    return row
