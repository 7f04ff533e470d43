"""Intervals of a line as the kernel's geometry: disks on a track, and half-lines that part them."""

from __future__ import annotations

from typing import NamedTuple, cast

from protocol.kernel.records import GONE, DiskRecord, Held
from protocol.kernel.robot import Bound
from tests.proof.link import Record

Span = tuple[int, int]


class Line(NamedTuple):
    """The low end stays where `sign` times its place is at most `sign` times `at`."""

    sign: int
    at: int


class Track:
    """Geometry of intervals; the answers of both halves of the kernel."""

    def __init__(self) -> None:
        self._noted: dict[int, list[Span]] = {}

    def note(self, disk: DiskRecord[Span]) -> None:
        self._noted[disk.name] = [] if disk.phase == GONE else [region for _, region in disk.held.regions]

    def around(self, disk: DiskRecord[Span], region: Span) -> list[int]:
        mine = [*self._noted[disk.name], region]
        return [
            name for name, theirs in self._noted.items() if any(overlap(a, b) for a in mine for b in theirs)
        ]

    def apart(self, one: Held[Span], other: Held[Span]) -> bool:
        return all(self.clear(other, region) for _, region in one.regions)

    def clear(self, held: Held[Span], region: Span) -> bool:
        return all(not overlap(mine, region) for _, mine in held.regions)

    def beside(self, held: Held[Span], line: Line, low: bool) -> bool:
        return all(self.fits(region, line, low) for _, region in held.regions)

    def within(self, place: Span, held: Held[Span]) -> bool:
        return any(self.inside(place, region) for _, region in held.regions)

    def inside(self, body: Span, region: Span) -> bool:
        return region[0] <= body[0] and body[1] <= region[1]

    def fits(self, body: Span, line: Line, low: bool) -> bool:
        side = line.sign if low else -line.sign
        return all(side * x <= side * line.at for x in body)

    def behind(self, place: Span, line: Line, low: bool) -> bool:
        return self.fits(place, line, low)

    def keeps(self, body: Span, bound: Bound[Span, Line]) -> bool:
        return all(self.fits(body, line, bound.low) for line in bound.obeyed)


def overlap(one: Span, other: Span) -> bool:
    return max(one[0], other[0]) < min(one[1], other[1])


Regions = dict[str, dict[int, Span]]


class TrackFacts:
    """What the track says of a record of two disks."""

    def __init__(self, regions: Regions, firsts: dict[int, Line | None], s: Record) -> None:
        self._regions, self._firsts, self._s, self._track = regions, firsts, s, Track()

    def apart(self, a: int, b: int) -> bool:
        one, other = self._regions["A"].get(a), self._regions["B"].get(b)
        return one is None or other is None or not overlap(one, other)

    def inside(self, x: str, body: Span, region: int) -> bool:
        return region in self._regions[x] and self._track.inside(body, self._regions[x][region])

    def beside(self, x: str, region: int, line: Line) -> bool:
        known = self._regions[x].get(region)
        return known is None or self._track.fits(known, line, x == "A")

    def fits(self, x: str, body: Span, line: Line) -> bool:
        return self._track.fits(body, line, x == "A")

    def disjoint(self, a: Span, b: Span) -> bool:
        return not overlap(a, b)

    def line(self, binding: int, number: int) -> Line:
        """As one of the ends keeps it, or the ledger; each line that is obeyed is kept by its end."""
        kinds = [b for b in "LS" if self._s[f"{b}.number"] == binding]
        for lines in (self._s[f"{b}.{x}.lines"] for b in kinds for x in "AB"):
            if number in lines:
                return cast(Line, lines[number])
        first = self._firsts[binding]
        assert first is not None
        assert number == 0
        return first
