"""A robot's part of the kernel: the constraints that one life obeys.

These are its region, and for each adopted binding the lines of the pair, or one half-plane towards the place
of a static disk.
"""

from __future__ import annotations

from typing import Final, Generic, Protocol

from mypy_extensions import mypyc_attr

from protocol.kernel.pair import Follower, Owner
from protocol.kernel.records import NO, B, B_contra, L, LifeGrants, Listed, R, require

ASKED: Final = 0  # asked for the first line, none is obeyed yet
LINES: Final = 1  # obeys the lines of the pair
HALF: Final = 2  # obeys one half-plane in place of them


@mypyc_attr(allow_interpreted_subclasses=True)
class OwnEnd(Generic[R, L]):
    """This robot's end of one binding.

    Attributes:
        number: of the binding.
        peer: the disk of the other end.
        low: whether this robot is the owner.
        state: ASKED, LINES or HALF.
        lines: end of the pair's protocol, once there is a first line.
        half: half-plane towards the place of the other disk.
        place: that place, if the other disk is static.
        static: whether it remains static as long as the binding is in force.
    """

    def __init__(self, listed: Listed[R, L], low: bool) -> None:
        self.number, self.peer, self.low = listed.number, listed.peer, low
        self.state = ASKED
        self.lines: Owner[L] | Follower[L] | None = None
        self.half: L | None = None
        self.place, self.static = listed.place, listed.static
        if listed.first is not None:
            self.begin(listed.first)

    def begin(self, first: L) -> None:
        """Obey the first line from now on."""
        self.state, self.lines = LINES, Owner(first) if self.low else Follower(first)

    def turn(self, half: L) -> None:
        """Obey one half-plane from now on."""
        self.state, self.half = HALF, half

    @property
    def obeyed(self) -> list[L]:
        """All lines that are obeyed."""
        if self.state == HALF and self.half is not None:
            return [self.half]
        return [] if self.lines is None else self.lines.obeyed()


class RobotGeometry(Protocol[R, L, B_contra]):
    """Geometric questions of a robot."""

    def inside(self, body: B_contra, region: R) -> bool:
        """Whether a body is in a region."""

    def fits(self, body: B_contra, line: L, low: bool) -> bool:
        """Whether a body is on one side of a line."""

    def behind(self, place: R, line: L, low: bool) -> bool:
        """Whether a place is on one side of a line."""

    def keeps(self, body: B_contra, end: OwnEnd[R, L]) -> bool:
        """Whether a body is on the own side of all obeyed lines of a binding."""


@mypyc_attr(allow_interpreted_subclasses=True)
class RobotLife(Generic[R, L, B]):
    """The constraints that one life of a robot obeys.

    Args:
        name: its id.
        life: number of its life.
        body: its body at the beginning.
        geometry: of bodies.

    Attributes:
        version: newest version of the ledger that was accepted.
        number, region: the obeyed region; NO and None before the first.
        offered_number, offered: the newest granted region.
        body: all that it covers now and until no command has any effect, with a part that it carries or
            reaches for.
        own: the same without that part.
        part: the disk of the part that it reaches for or puts down, or NO.
        ends: its ends of bindings, by number of the binding.
    """

    def __init__(self, name: int, life: int, body: B, geometry: RobotGeometry[R, L, B]) -> None:
        self.name, self.life = name, life
        self.body, self.own, self.part = body, body, NO
        self.version = self.number = self.offered_number = NO
        self.region: R | None = None
        self.offered: R | None = None
        self.ends: dict[int, OwnEnd[R, L]] = {}
        self._geometry = geometry

    def body_towards(self, end: OwnEnd[R, L]) -> B:
        """The body that a binding constrains."""
        return self.own if end.peer == self.part else self.body

    def fits(self, end: OwnEnd[R, L], line: L) -> bool:
        """Whether the body is on the own side of a line, now and until no command has any effect."""
        return self._geometry.fits(self.body_towards(end), line, end.low)

    def receive(self, grants: LifeGrants[R, L]) -> None:
        """Accept a Tick. Bindings that it does not list are over; it adopts listed ones before its region."""
        require(grants.life == self.life, "receive: it is for this life")
        require(grants.version > self.version, "receive: it is newer than any before")
        known, self.ends = self.ends, {}
        for listed in grants.bindings:
            end = known.get(listed.number)
            if end is None:
                end = OwnEnd(listed, self.name < listed.peer)
            else:
                end.place, end.static = listed.place, listed.static
            self.ends[listed.number] = end
        self.version = grants.version
        self.offered_number, self.offered = grants.number, grants.region

    def freeze(self, end: OwnEnd[R, L], line: L) -> None:
        """Obey this first line, for which the robot was asked, and announce it."""
        require(end.state == ASKED, "freeze: there is no first line")
        require(end.place is not None, "freeze: the other end stands")
        require(line in self.kept(end) or self.fits(end, line), "freeze: the body fits the line")
        require(self.behind(end, line), "freeze: the place is behind the line")
        end.begin(line)

    def turn(self, end: OwnEnd[R, L], line: L) -> None:
        """Obey one half-plane towards the place of a static disk, in place of all lines obeyed before."""
        require(end.state != ASKED, "turn: a first line is obeyed")
        require(end.static, "turn: the other end stands for good")
        require(self.fits(end, line), "turn: the body fits the line")
        require(self.behind(end, line), "turn: the place is behind the line")
        end.turn(line)

    def kept(self, asked: OwnEnd[R, L]) -> list[L]:
        """Lines that the body keeps to already, towards an earlier life of the same disk."""
        found: list[L] = []
        for end in self.ends.values():
            if end.static and end.peer == asked.peer:
                found.extend(end.obeyed)
        return found

    def behind(self, end: OwnEnd[R, L], line: L) -> bool:
        """Whether the place of the other disk, which is static, is on the other side of a line."""
        return end.place is not None and self._geometry.behind(end.place, line, not end.low)

    def adopt(self) -> None:
        """Obey the newest granted region, once the body is inside."""
        offered = self.offered
        require(self.offered_number > self.life, "adopt region: it was granted to this life")
        require(self.offered_number > self.number, "adopt region: it is newer than the one obeyed")
        require(
            offered is not None and self._geometry.inside(self.body, offered),
            "adopt region: the body is inside",
        )
        self.number, self.region = self.offered_number, offered

    def locate(self, body: B, own: B) -> None:
        """Replace the body by a measured, smaller one within that of the last `command`."""
        self.body, self.own = body, own

    def command(self, body: B, own: B, part: int = NO) -> None:
        """Command a motion, or another shape of the body.

        Args:
            body: all that is covered now and until no command has any effect.
            own: the same without the part that the robot carries or reaches for.
            part: the disk of a part that it reaches for or puts down, which constrains `own` only.
        """
        region = self.region
        require(region is not None, "command: a region was adopted")
        require(region is not None and self._geometry.inside(body, region), "command: it stays in the region")
        for end in self.ends.values():
            covered = own if end.peer == part else body
            require(self._geometry.keeps(covered, end), "command: it keeps to what is obeyed")
        self.body, self.own, self.part = body, own, part
