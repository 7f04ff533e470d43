"""Verifies a certificate: each node of its branching is narrowed, refuted, shown to descend, or halved.

The stored branching is only advice on which row to halve and where to stop; the proof is made here. Where it
stops too early for these bounds, the box is halved further.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

from flint import arb

from deploy.output import bar
from deploy.theory.certify.certificate import DEEPEST, EMPTY, Certificate, GoalSet
from deploy.theory.certify.conditions import ZERO, BoxConditions, Rows, middle, whole
from deploy.theory.certify.descent import descends, newton
from protocol.process.signals import Stopped

_ROUNDS = 8
_WORTH = 0.9
_NEWTON_BELOW = 0.75
_FURTHER = 500  # boxes into which one stored leaf may be halved


@dataclass(frozen=True)
class Replay:
    """Result of a verification."""

    scenario: str
    claimed: float | None
    verified: float | None  # the smallest verified K, if any
    boxes: int
    failed: str | None
    interrupted: bool

    def enough(self, k: float | None) -> bool:
        """Whether `k`, or without one the whole claim of the file, is verified."""
        wanted = self.claimed if k is None else k
        return self.verified is not None and wanted is not None and self.verified <= wanted


class _StoppedError(Exception):
    """No further slab is verified; the text gives the reason."""


def replay(certificate: Certificate, minutes: float, quiet: bool = True) -> Replay:
    """Verify slab by slab, from large k downwards, for at most `minutes`."""
    until = time.monotonic() + 60.0 * minutes
    total, boxes = max(1, certificate.boxes), 0
    proven, failed, interrupted = None, None, False
    before: arb = ZERO

    with bar("verifying", silent=quiet) as tell:
        try:
            for slab in certificate.slabs:
                kappa = 1 / arb(slab.k)
                walk = Walk(certificate.goals, slab.nodes)
                try:
                    for nodes in walk.run(whole(certificate.goals, (before.lower(), kappa.upper()))):
                        tell(min(1.0, (boxes + nodes) / total))
                        if time.monotonic() > until:
                            raise _StoppedError(f"time is up after {minutes:g} minutes")
                finally:
                    boxes += walk.boxes
                before, proven = kappa, slab.k
        except _StoppedError as error:
            failed = str(error)
        except Stopped:
            interrupted = True
    return Replay(certificate.scenario, certificate.proven, proven, boxes, failed, interrupted)


class Walk:
    """One slab."""

    def __init__(self, goals: GoalSet, branching: bytes) -> None:
        self._goals, self._nodes = goals, branching
        self._at = 0  # next stored node
        self._further = 0
        self.boxes = 0
        p = len(goals.radii)
        self._leaf = 2 * p + p * (p + 1) // 2 + 1  # this number and higher ones are no rows
        self._sets = [frozenset(set_) for size in range(1, p + 1) for set_ in combinations(range(p), size)]
        self._unit = goals.radii[0] + goals.radii[1] if p > 1 else goals.workspace - goals.radii[0]

    def run(self, rows: Rows) -> Iterator[int]:
        """Yields the number of stored nodes so far. Raises _StoppedError if a box is neither refuted nor
        shown to descend.
        """
        stack: list[tuple[Rows | None, bool]] = [(rows, True)]
        while stack:
            stack.extend(reversed(self._node(*stack.pop())))
            if len(stack) > DEEPEST + _FURTHER:
                raise _StoppedError("the branching is too deep: the certificate is damaged")
            yield self._at
        if self._at != len(self._nodes):
            raise _StoppedError("the branching has nodes after its last one: the certificate is damaged")

    def _node(self, rows: Rows | None, stored: bool) -> list[tuple[Rows | None, bool]]:
        """Halves of a box, or of None, which is decided already; each, and the box, with whether the
        branching has a node for it.
        """
        advice = self._next() if stored else EMPTY
        leaf = advice >= self._leaf
        self.boxes += rows is not None
        if rows is None or self.settled(box := BoxConditions(self._goals, rows)):
            return [] if leaf else [(None, True), (None, True)]
        self._further = 0 if stored else self._further + 1
        if self._further > _FURTHER:
            raise _StoppedError("a box was not verified after many halvings")
        row = self._widest(box) if leaf else advice
        cut = arb(middle(box.rows[row]))
        left, right = [[*each] for each in box.rows], [[*each] for each in box.rows]
        left[row][1] = right[row][0] = cut
        return [(half, not leaf) for half in (left, right)]

    def _next(self) -> int:
        if self._at >= len(self._nodes):
            raise _StoppedError("the branching ends before its last node: the certificate is damaged")
        self._at += 1
        return self._nodes[self._at - 1]

    def settled(self, box: BoxConditions) -> bool:
        """Narrow a box in place; whether it contains no minimum."""
        if not box.upright() or not self.narrowed(box):
            return True
        span = max(_width(box, row) for row in range(box.n))
        if span < _NEWTON_BELOW * self._unit and not (newton(box) and self.narrowed(box)):
            return True
        return descends(box)

    def narrowed(self, box: BoxConditions) -> bool:
        """Narrow a box around its critical points. False: there are none."""
        for _ in range(_ROUNDS):
            before = _size(box)
            if not (box.derive() and box.distances() and box.work()):
                return False
            for members in self._sets:
                if not (box.balance(members) and box.torque(members)):
                    return False
            if not _size(box) < _WORTH * before:
                break
        return box.derive()

    def _widest(self, box: BoxConditions) -> int:
        """The widest row of b or kappa."""
        kappa = _width(box, len(box.rows) - 1) / float(box.rows[-1][1].mid()) * 0.1 * self._unit
        widths = {row: _width(box, row) for row in range(box.n)} | {len(box.rows) - 1: kappa}
        return max(widths, key=lambda row: widths[row])


def _width(box: BoxConditions, row: int) -> float:
    low, high = box.rows[row]
    return float((high - low).mid())


def _size(box: BoxConditions) -> float:
    n = box.n
    side = _width(box, 0)
    weights = sum(min(_width(box, row), 10.0) for row in range(n, len(box.rows) - 1))
    return sum(_width(box, row) for row in range(n)) + 0.1 * side * weights
