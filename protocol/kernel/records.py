"""Data types of the kernel.

Every change of the ledger has a number, its version, which also names the life, region or binding that it
makes; no number is used twice. A **region** is a set of points that contains a whole disk; the place of a
static disk is one, too. A **line** divides the plane; the lower id of a binding stays on its low side, the
higher id on its high side. A **body** is all that a robot may cover, now and until no command has any effect.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final, Generic, Protocol, TypeVar

from mypy_extensions import mypyc_attr

from protocol.errors import DisknavError

R = TypeVar("R")  # region
L = TypeVar("L")  # line
L_contra = TypeVar("L_contra", contravariant=True)
B = TypeVar("B")  # body
B_contra = TypeVar("B_contra", contravariant=True)

NO: Final = 0  # no version, no life, no disk

GONE: Final = 0  # not in the workspace
ANNOUNCED: Final = 1  # to appear, not in the workspace yet
PRESENT: Final = 2


class RefusedError(DisknavError):
    """A rule of the kernel refuses a request; the text names the rule and its precondition."""


def require(holds: bool, what: str) -> None:
    """Check a precondition of a rule; raises RefusedError."""
    if not holds:
        raise RefusedError(what)


@mypyc_attr(allow_interpreted_subclasses=True)
class Held(Generic[R]):
    """The regions that a disk holds: the one confirmed last and all granted since.

    Args:
        number: of the first region.
        region: contains the disk.

    Attributes:
        acknowledged: number of the region confirmed last, or of the static place.
        granted: number of the newest region.
        regions: all from the former to the latter, by ascending number.
    """

    def __init__(self, number: int, region: R) -> None:
        self.acknowledged = number
        self.granted = number
        self.regions: list[tuple[int, R]] = [(number, region)]

    def grant(self, number: int, region: R) -> None:
        """Add a region."""
        self.granted = number
        self.regions.append((number, region))

    def acknowledge(self, number: int) -> None:
        """Drop regions older than this number."""
        self.acknowledged = number
        self.regions = [each for each in self.regions if each[0] >= number]

    def stand(self, number: int, place: R) -> None:
        """Hold the place of a static disk alone."""
        self.acknowledged = self.granted = number
        self.regions = [(number, place)]


@mypyc_attr(allow_interpreted_subclasses=True)
class DiskRecord(Generic[R]):
    """A robot's disk, an obstacle or a part in the ledger.

    Args:
        name: its id; lower ids are on the low sides of lines.
        held: the regions that it holds.

    Attributes:
        phase: GONE, ANNOUNCED or PRESENT.
        life: the life that may move it, or NO.
        still: whether it is static, and holds its place alone.
    """

    def __init__(self, name: int, held: Held[R], phase: int) -> None:
        self.name, self.held, self.phase = name, held, phase
        self.life = NO
        self.still = True


@mypyc_attr(allow_interpreted_subclasses=True)
class End:
    """One end of a binding in the ledger.

    Attributes:
        disk: its disk.
        life: the life that obeys the binding; NO for a static place.
        dead: version at which this life ended, or the end became a place; NO while it lives.
    """

    def __init__(self, disk: int, life: int, dead: int) -> None:
        self.disk, self.life, self.dead = disk, life, dead


@mypyc_attr(allow_interpreted_subclasses=True)
class Binding(Generic[L]):
    """A binding of two disks: the lines that one end obeys towards the other.

    It is **in force** from the version that has its first line. That needs no confirmation: the line
    separates all that both held then, and Ticks list it with every later region.

    Attributes:
        number: version that began it.
        low, high: its ends.
        asked: the disk that was asked for the first line; NO if the coordinator gave it.
        first: the first line.
        since: version that has the first line; NO while it is unknown.
    """

    def __init__(self, number: int, low: End, high: End, asked: int, first: L | None) -> None:
        self.number, self.low, self.high = number, low, high
        self.asked, self.first = asked, first
        self.since = NO if first is None else number

    def end(self, disk: int) -> End:
        """The end of this disk."""
        return self.low if disk == self.low.disk else self.high

    def other(self, disk: int) -> End:
        return self.high if disk == self.low.disk else self.low


@mypyc_attr(allow_interpreted_subclasses=True)
class Listed(Generic[R, L]):
    """One binding in a Tick to the life of one end.

    Attributes:
        number: of the binding.
        peer: the disk of the other end.
        first: the first line; None if this end is asked for it.
        place: the other disk's place, if it is static.
        static: whether it remains static as long as the binding is in force.
    """

    def __init__(self, number: int, peer: int, first: L | None, place: R | None, static: bool) -> None:
        self.number, self.peer, self.first = number, peer, first
        self.place, self.static = place, static


@mypyc_attr(allow_interpreted_subclasses=True)
class LifeGrants(Generic[R, L]):
    """Everything in the ledger that concerns one life, at one version.

    Attributes:
        life: the addressee.
        version: of the ledger.
        number, region: newest region granted to it.
        bindings: all of its bindings.
    """

    def __init__(self, life: int, version: int, number: int, region: R, bindings: list[Listed[R, L]]) -> None:
        self.life, self.version = life, version
        self.number, self.region, self.bindings = number, region, bindings


class LedgerGeometry(Protocol[R, L_contra]):
    """Geometric questions of the ledger."""

    def note(self, disk: DiskRecord[R]) -> None:
        """Note a change of the regions that a disk holds, or of its presence."""

    def around(self, disk: DiskRecord[R], region: R) -> Iterable[int]:
        """Names of all disks, possibly without some that are gone, or that hold only regions disjoint from
        this one and from all that the disk holds.
        """

    def apart(self, one: Held[R], other: Held[R]) -> bool:
        """Whether all regions of the two are disjoint."""

    def clear(self, held: Held[R], region: R) -> bool:
        """Whether all held regions are disjoint from this one."""

    def beside(self, held: Held[R], line: L_contra, low: bool) -> bool:
        """Whether all held regions are on one side of a line."""

    def within(self, place: R, held: Held[R]) -> bool:
        """Whether a place is inside a held region."""
