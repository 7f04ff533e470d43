"""Contacts: when, and how deeply, two disks overlapped, or a disk and the boundary or a thing.

A contact is a gap below `-TOUCH`: rounding at an exact touch is none. What the plant itself saw of contacts
is kept beside.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from protocol.geometry import Disk
from world.judge.clearance import Disks, Plane, Reals

_STILL = 1e-280  # m^2, a motion too short for its square to be exact: none
TOUCH = 1e-9  # m
_SAME = 1e-6  # ticks; an interval that ends at a tick and one that begins there are one

Interval = tuple[float, float]
Pair = tuple[int, int]


@dataclass
class Contact:
    """An overlap of `pair` (0: the boundary, -n: thing n); times in ticks, `deepest` in m, negative."""

    pair: tuple[int, int]
    begin: float
    end: float
    deepest: float


class Contacts:
    """All contacts of a run, in the order in which they began."""

    def __init__(self) -> None:
        self.all: list[Contact] = []
        self._latest: dict[tuple[int, int], Contact] = {}

    def recast(self) -> None:
        """Other disks from now on; an overlap that goes on is noted anew."""
        self._latest = {}

    def add(
        self, tick: float, disks: Disks, gaps: Reals, before: Plane, after: Plane, span: float = 1.0
    ) -> None:
        """Note the contacts of `disks` during a straight motion that begins at `tick` and takes `span` ticks,
        given its gaps (`clearance.gaps`)."""
        if gaps.min() >= -TOUCH:
            return
        for index in (gaps < -TOUCH).nonzero()[0].tolist():
            for begin, end in _intervals(disks, index, before, after):
                self._note(disks.names(index), tick + span * begin, tick + span * end, float(gaps[index]))

    def _note(self, pair: tuple[int, int], begin: float, end: float, gap: float) -> None:
        latest = self._latest.get(pair)
        if latest is not None and begin <= latest.end + _SAME:
            latest.end = end
            latest.deepest = min(latest.deepest, gap)
            return
        self._latest[pair] = Contact(pair, begin, end, gap)
        self.all.append(self._latest[pair])


def _intervals(disks: Disks, index: int, before: Plane, after: Plane) -> list[Interval]:
    pairs = len(disks.contact)
    if index < pairs:
        i, j = disks.first[index], disks.second[index]
        inside = within(before[i] - before[j], after[i] - after[j], disks.contact[index] - TOUCH)
        return [] if inside is None else [inside]
    robot, surroundings = (index - pairs) % len(disks.ids), disks.surroundings
    if index - pairs >= len(disks.ids) or not isinstance(surroundings.room, Disk):
        return surroundings.overlaps(index - pairs, before[robot], after[robot], TOUCH)
    inside = within(before[robot], after[robot], surroundings.wall[robot] + TOUCH)
    if inside is None:
        return [(0.0, 1.0)]
    return [part for part in ((0.0, inside[0]), (inside[1], 1.0)) if part[0] < part[1]]


def within(start: complex, end: complex, radius: float) -> Interval | None:
    """The part of [0, 1] in which start + t (end - start) is within `radius` of the origin."""
    motion = end - start
    squared = abs(motion) ** 2
    excess = abs(start) ** 2 - radius**2
    along = (start.conjugate() * motion).real
    if squared < _STILL:
        return (0.0, 1.0) if excess <= 0.0 else None
    discriminant = along**2 - squared * excess
    if discriminant < 0.0:
        return None
    root = math.sqrt(discriminant)
    first, last = max((-along - root) / squared, 0.0), min((-along + root) / squared, 1.0)
    return (float(first), float(last)) if first <= last else None


class Touches:
    """All contacts that a plant has reported, each once, in the order in which they began.

    Attributes:
        all: tick and pair of ids.
    """

    def __init__(self) -> None:
        self.all: list[tuple[int, Pair]] = []
        self._present: set[Pair] = set()

    def add(self, tick: int, pairs: Sequence[Pair]) -> None:
        """Take note of the pairs that touched in a tick."""
        present = set(pairs)
        self.all += ((tick, pair) for pair in sorted(present - self._present))
        self._present = present
