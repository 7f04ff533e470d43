"""Data types of the kernel's rules.

Every change of the ledger has a number, its version. What a change makes (a life, a region, a binding) is
known by that number, so that no number ever returns. A **region** is a set of points that holds a whole disk:
the place where a disk stands is one, too. A **line** parts the plane; the lower id of a binding stays on its
low side, the higher id on its high side. A **body** is all that a robot may cover, now and until no command
has any effect.
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

NO: Final = 0  # of a version: never; of a life: none; of a disk: none

GONE: Final = 0  # not in the workspace
ANNOUNCED: Final = 1  # is to appear: nothing is there yet
PRESENT: Final = 2


class RefusedError(DisknavError):
    """A rule of the kernel does not allow what was asked; the text names the rule and its precondition."""


def require(holds: bool, what: str) -> None:
    """A precondition of a rule.

    Raises:
        RefusedError: it does not hold.
    """
    if not holds:
        raise RefusedError(what)


@mypyc_attr(allow_interpreted_subclasses=True)
class Held(Generic[R]):
    """Every region that a disk may be in: those granted since the one that it is known to obey.

    Args:
        number: of the first region.
        region: in which the disk is.

    Attributes:
        acknowledged: number of the region that it is known to obey, or of the place where it stands.
        granted: number of the newest.
        regions: all from the one to the other, by number, ascending.
    """

    def __init__(self, number: int, region: R) -> None:
        self.acknowledged = number
        self.granted = number
        self.regions: list[tuple[int, R]] = [(number, region)]

    def grant(self, number: int, region: R) -> None:
        """The disk may be in another region as well."""
        self.granted = number
        self.regions.append((number, region))

    def acknowledge(self, number: int) -> None:
        """The disk is in the region of this number, or in a later one."""
        self.acknowledged = number
        self.regions = [each for each in self.regions if each[0] >= number]

    def stand(self, number: int, place: R) -> None:
        """The disk stands at a place, and leaves everything else."""
        self.acknowledged = self.granted = number
        self.regions = [(number, place)]


@mypyc_attr(allow_interpreted_subclasses=True)
class DiskRecord(Generic[R]):
    """A robot's disk, an obstacle or a part, as the ledger keeps it.

    Args:
        name: its id; lower ids are on the low sides of lines.
        held: what it holds.

    Attributes:
        phase: GONE, ANNOUNCED or PRESENT.
        life: the life that may move it, or NO.
        still: whether it stands, so that all it holds is its place.
    """

    def __init__(self, name: int, held: Held[R], phase: int) -> None:
        self.name, self.held, self.phase = name, held, phase
        self.life = NO
        self.still = True


@mypyc_attr(allow_interpreted_subclasses=True)
class End:
    """One end of a binding in the ledger.

    Attributes:
        disk: to which it belongs.
        life: that obeys the binding; NO: a place obeys nothing.
        dead: version since which this life is over, or the end is a place; NO as long as it lives.
    """

    def __init__(self, disk: int, life: int, dead: int) -> None:
        self.disk, self.life, self.dead = disk, life, dead


@mypyc_attr(allow_interpreted_subclasses=True)
class Binding(Generic[L]):
    """Two disks that are bound to each other: what one end obeys towards the other.

    It **counts** from the version on that tells its first line. It needs no acknowledgement: the line parts
    all that both held then, and whatever is granted later comes with it.

    Attributes:
        number: version that began it.
        low, high: its ends.
        asked: the disk that was asked for the first line; NO if that was given.
        first: the first line.
        told: version that tells it; NO as long as it is not known.
    """

    def __init__(self, number: int, low: End, high: End, asked: int, first: L | None) -> None:
        self.number, self.low, self.high = number, low, high
        self.asked, self.first = asked, first
        self.told = NO if first is None else number

    def end(self, disk: int) -> End:
        """The end of one of its disks."""
        return self.low if disk == self.low.disk else self.high

    def other(self, disk: int) -> End:
        """The other end."""
        return self.high if disk == self.low.disk else self.low


@mypyc_attr(allow_interpreted_subclasses=True)
class Listed(Generic[R, L]):
    """One binding, as a Tick tells it to the life of one end.

    Attributes:
        number: of the binding.
        peer: the disk of the other end.
        first: the first line; None: this end is asked for one.
        place: where the other end stands, if it does.
        static: whether it stands for as long as the binding is in force.
    """

    def __init__(self, number: int, peer: int, first: L | None, place: R | None, static: bool) -> None:
        self.number, self.peer, self.first = number, peer, first
        self.place, self.static = place, static


@mypyc_attr(allow_interpreted_subclasses=True)
class Told(Generic[R, L]):
    """Everything that the ledger has to say to one life, as a whole, at one version.

    Attributes:
        life: that is addressed.
        version: of the ledger.
        number, region: newest region granted to it.
        bindings: all that are in force and concern it.
    """

    def __init__(self, life: int, version: int, number: int, region: R, bindings: list[Listed[R, L]]) -> None:
        self.life, self.version = life, version
        self.number, self.region, self.bindings = number, region, bindings


class LedgerGeometry(Protocol[R, L_contra]):
    """What the ledger has to know of regions and lines."""

    def note(self, disk: DiskRecord[R]) -> None:
        """What a disk holds, or whether it is there, has changed."""

    def around(self, disk: DiskRecord[R], region: R) -> Iterable[int]:
        """Names of all disks, perhaps but for some that are gone or hold nothing that meets the region, or
        what the disk holds, as it was noted."""

    def apart(self, one: Held[R], other: Held[R]) -> bool:
        """Whether no region that the one holds meets one that the other holds."""

    def clear(self, held: Held[R], region: R) -> bool:
        """Whether no region held meets this one."""

    def beside(self, held: Held[R], line: L_contra, low: bool) -> bool:
        """Whether all regions held are on one side of a line."""

    def within(self, place: R, held: Held[R]) -> bool:
        """Whether a place is in a region that is held."""
