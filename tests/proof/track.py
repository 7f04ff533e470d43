"""Intervals of a line as the kernel's geometry: disks on a track, and half-lines that part them."""

from __future__ import annotations

from typing import NamedTuple

from protocol.kernel.records import GONE, DiskRecord, Held
from protocol.kernel.robot import Bound
from tests.proof.link import Facts

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


class TrackFacts(Facts):
    """What the track says of a record of two disks."""

    def inside(self, x: str, body: Span, region: int) -> bool:
        return region in self.regions[x] and Track().inside(body, self.regions[x][region])

    def fits(self, x: str, body: Span, line: Line) -> bool:
        return Track().fits(body, line, x == "A")

    def disjoint(self, a: Span, b: Span) -> bool:
        return not overlap(a, b)
