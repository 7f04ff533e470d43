"""Branch and bound, depth first: every box is emptied, certified by curvature, or halved.

Interval Newton is that of Hansen and Sengupta in (b, lambda), with kappa as an interval parameter. Equations,
with b0, lambda0 the midpoint: F_i = b_i - g_i - sum lambda_ij d_ij + lambda_0i b_i and F_q = lambda_q beta_q
- kappa gamma. For every (b, lambda) in the box F(b, lambda) - F(b0, lambda0) = S (b - b0, lambda - lambda0),
where the rows of S hold M(lambda0), d_q over the box, lambda0 (d + d0), beta_q over the box, and kappa (y +
y0). That is tighter than a Jacobian over the box, and exact at contact.

NumPy's dense linear algebra makes proposals only, never bounds.
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
    derived,
    divide,
    ends,
    inverted,
    middle,
    mul,
    narrow,
    solve_into,
    square,
    sub,
    whole,
)
from deploy.theory.certify.certificate import DEEPEST, EMPTY, FALLS, MOST_BOXES
from deploy.theory.certify.contractors import (
    contract_balance,
    contract_distances,
    contract_rotation,
    contract_torque,
    contract_work,
    enclose,
    enclose_work,
)
from deploy.theory.certify.curvature import falls
from protocol.arrays import Reals

_UNBOUNDED = 1e50  # larger multipliers may overflow


@compiled
def _accumulate(array: Reals, row: int, value: Interval) -> None:
    array[row] = add(ends(array, row), value)


@compiled
def _system(scene: Scene, box: Box, out: Derived, at: Reals, value: Reals, slope: Reals) -> None:
    """F at the midpoint `at`, for every kappa of the box, and S."""
    n, factors = len(scene.goals), len(scene.first)
    kappa = ends(box, -1)
    slope[:] = 0.0
    gamma = (0.0, 0.0)
    for row in range(n):
        y = sub((at[row], at[row]), (scene.goals[row], scene.goals[row]))
        value[row] = y
        gamma = add(gamma, square(y))
        slope[row, row] = 1.0, 1.0
        both = mul(kappa, add(y, ends(out.pull, row)))
        for q in range(factors):
            slope[n + q, row] = -both[1], -both[0]
    target = mul(kappa, gamma)
    for q in range(factors):
        i, j = scene.first[q], scene.second[q]
        weight, opposite = (at[n + q], at[n + q]), (-at[n + q], -at[n + q])
        far = (0.0, 0.0)
        for a in range(2):
            one, two = 2 * i + a, 2 * j + a
            there = (at[one], at[one])
            if j >= 0:
                there = sub(there, (at[two], at[two]))
            here = ends(out.apart[q], a)
            far = add(far, square(there))
            force = mul(weight, there)
            along = mul(weight, add(here, there))
            if j < 0:
                _accumulate(value, one, force)
                _accumulate(slope[one], one, weight)
                slope[one, n + q] = here
                _accumulate(slope[n + q], one, (-along[1], -along[0]))
            else:
                _accumulate(value, one, (-force[1], -force[0]))
                _accumulate(value, two, force)
                _accumulate(slope[one], one, opposite)
                _accumulate(slope[two], two, opposite)
                _accumulate(slope[one], two, weight)
                _accumulate(slope[two], one, weight)
                slope[one, n + q] = -here[1], -here[0]
                slope[two, n + q] = here
                _accumulate(slope[n + q], one, along)
                _accumulate(slope[n + q], two, (-along[1], -along[0]))
        contact = ends(scene.contact, q)
        beta = sub(contact, far) if j < 0 else sub(far, contact)
        total = sub(mul(weight, beta), target)
        value[n + q] = total
        slope[n + q, n + q] = out.beta[q]


@compiled
def contract_newton(scene: Scene, box: Box, out: Derived) -> bool:
    """Contract (b, lambda); unchanged if a lambda is huge or the midpoint's S singular."""
    size = len(box) - 1
    if not (box[:size, 1] < _UNBOUNDED).all():
        return True
    at = np.empty(size)
    for row in range(size):
        at[row] = middle(ends(box, row))
    value, slope = np.empty((size, 2)), np.empty((size, size, 2))
    _system(scene, box, out, at, value, slope)
    inverse = np.empty((size, size))
    if not solve_into(0.5 * (slope[:, :, 0] + slope[:, :, 1]), inverse):
        return True
    for row in range(size):
        _newton_row(box, at, value, slope, inverse, row)
    return not inverted(box, size)


@compiled
def _newton_row(box: Box, at: Reals, value: Reals, slope: Reals, inverse: Reals, row: int) -> None:
    """One row of C F(b0, lambda0) + C S (x - x0) = 0, solved for its own unknown."""
    size = len(at)
    rest = (0.0, 0.0)
    own = (1.0, 1.0)
    for r in range(size):
        rest = sub(rest, mul((inverse[row, r], inverse[row, r]), ends(value, r)))
    for column in range(size):
        entry = (0.0, 0.0)
        for r in range(size):
            if slope[r, column, 0] != 0.0 or slope[r, column, 1] != 0.0:
                entry = add(entry, mul((inverse[row, r], inverse[row, r]), ends(slope[r], column)))
        if column == row:
            own = entry
        else:
            step = sub(ends(box, column), (at[column], at[column]))
            rest = sub(rest, mul(entry, step))
    if own[0] <= 0.0 <= own[1]:
        return
    narrow(box, row, add((at[row], at[row]), divide(rest, own)))


OPEN = -1

# Choices by measurement, which do not affect the validity of a proof.
_ROUNDS = 8
_WORTH = 0.9  # contract again while the box shrinks below this share
_NEWTON_BELOW = 0.75  # largest span of b for interval Newton, contact distances
_KAPPA_WIDTH = 0.5  # width of the whole range of kappa, contact distances


class Search:
    """Branch and bound over one range of 1/k, in portions."""

    def __init__(self, scene: Scene, kappa: tuple[float, float]) -> None:
        root = whole(scene, kappa)
        self._scene, self._largest, self._out = scene, kappa[1], derived(scene)
        self._stack = np.empty((DEEPEST, *root.shape))
        self._level = np.zeros(DEEPEST, dtype=np.int64)  # a box is 2^-level of the whole
        self._stack[0], self._height = root, 1
        self._tape: list[bytes] = []
        self.nodes = 0  # boxes processed
        self.stuck = False  # a box was halved to the depth limit, or there are too many

    @property
    def open(self) -> Reals:
        """Boxes still to be processed."""
        return self._stack[: self._height]

    @property
    def done(self) -> float:
        """Share of the whole that is done, 0 to 1, by halvings."""
        return 1.0 - float((0.5 ** self._level[: self._height]).sum())

    @property
    def branching(self) -> bytes:
        """One byte per node in preorder; complete when no box is open."""
        return b"".join(self._tape)

    def advance(self, nodes: int) -> bool:
        """Process at most `nodes` boxes; False at the end."""
        tape = np.empty(nodes, dtype=np.uint8)
        state = (self._stack, self._level, self._height)
        self._height, written = _advance(self._scene, *state, self._out, tape, self._largest)
        self._tape.append(tape[:written].tobytes())
        self.nodes += written
        self.stuck = self._height == DEEPEST or self.nodes > MOST_BOXES
        return self._height > 0 and not self.stuck


@compiled
def _advance(
    scene: Scene,
    stack: Reals,
    level: NDArray[np.int64],
    height: int,
    out: Derived,
    tape: NDArray[np.uint8],
    kappa: float,
) -> tuple[int, int]:
    """Process boxes until the stack is empty or full, or the tape is full: (height left, tape written)."""
    written = 0
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
    """Contract a box in place around its minima: EMPTY, FALLS, or OPEN if undecided."""
    if not contract_rotation(scene, box) or not contract(scene, box, out):
        return EMPTY
    places = box[: len(scene.goals)]
    if (places[:, 1] - places[:, 0]).max() < _NEWTON_BELOW * np.sqrt(scene.contact[0, 0]) and not (
        contract_newton(scene, box, out) and contract(scene, box, out)
    ):
        return EMPTY
    return FALLS if falls(scene, box, out) else OPEN


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
    """Weighted sum of widths, which decreases with worthwhile contractions."""
    n, total = len(scene.goals), 0.0
    for row in range(n):
        total += box[row, 1] - box[row, 0]
    for row in range(n, len(box) - 1):
        total += 0.1 * min(box[row, 1] - box[row, 0], 10.0) * (box[0, 1] - box[0, 0])
    return total


@compiled
def widest(scene: Scene, box: Box, kappa: float) -> int:
    """The row to halve: of b or, if its share of [0, kappa] is wide, kappa."""
    last = len(box) - 1
    unit = np.sqrt(scene.contact[0, 0])
    best, row = _KAPPA_WIDTH * unit * (box[last, 1] - box[last, 0]) / kappa, last
    for candidate in range(len(scene.goals)):
        if box[candidate, 1] - box[candidate, 0] > best:
            best, row = box[candidate, 1] - box[candidate, 0], candidate
    return row
