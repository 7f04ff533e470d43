"""Contacts: when, and how deeply, two disks overlapped, or a disk and the boundary or an obstacle.

A contact is a gap below `-TOUCH`: rounding at an exact touch is none. What the plant itself saw of contacts
is kept beside.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from world.judge.clearance import Disks, Plane, Reals

TOUCH = 1e-9  # m
_SAME = 1e-6  # ticks; an interval that ends at a tick and one that begins there are one

Pair = tuple[int, int]


@dataclass
class Contact:
    """An overlap of `pair` (0: the boundary, -n: obstacle n); times in ticks, `deepest` in m, negative."""

    pair: Pair
    begin: float
    end: float
    deepest: float


class Contacts:
    """All contacts of a run, in the order in which they began.

    Args:
        past: those up to here; an overlap that goes on is another contact.
    """

    def __init__(self, past: Iterable[Contact] = ()) -> None:
        self.all = [*past]
        self._latest: dict[Pair, Contact] = {}

    def end(self) -> None:
        """The disks are others from now on: an overlap that goes on is another contact."""
        self._latest = {}

    def add(
        self, tick: float, disks: Disks, gaps: Reals, before: Plane, after: Plane, span: float = 1.0
    ) -> None:
        """Take in the contacts of `disks` during a straight motion that begins at `tick` and takes `span`
        ticks, given its gaps (`clearance.gaps`)."""
        for index in (gaps < -TOUCH).nonzero()[0].tolist() if gaps.min() < -TOUCH else ():
            for begin, end in disks.overlaps(index, before, after, TOUCH):
                self._note(disks.names(index), tick + span * begin, tick + span * end, float(gaps[index]))

    def _note(self, pair: Pair, begin: float, end: float, gap: float) -> None:
        latest = self._latest.get(pair)
        if latest is not None and begin <= latest.end + _SAME:
            latest.end, latest.deepest = end, min(latest.deepest, gap)
            return
        self._latest[pair] = Contact(pair, begin, end, gap)
        self.all.append(self._latest[pair])


class Touches:
    """All contacts that a plant has reported, each once, as tick and pair of ids, in the order in which they
    began; `past` are those up to here."""

    def __init__(self, past: Iterable[tuple[int, Pair]] = ()) -> None:
        self.all = [*past]
        self._present: set[Pair] = set()

    def add(self, tick: int, pairs: Sequence[Pair]) -> None:
        """Take in the pairs that touched in a tick."""
        present = set(pairs)
        self.all += ((tick, pair) for pair in sorted(present - self._present))
        self._present = present
