"""One binding of a robot: the kernel's own end, and what follows from it for the robot's centre."""

from __future__ import annotations

from typing import final

from agents.lines.own_set import OwnSet
from agents.peers.state import PeerState
from protocol.kernel.pair import Owner
from protocol.kernel.robot import ASKED, LINES, Bound
from protocol.line import HalfPlane, Line
from protocol.region import Region, is_beside


@final
class Cover:
    """All that a robot covers now and until no command has any effect: a disk with its centre in a set.

    Args:
        own: where the centre may be, and what it still passes.
        radius: of the disk, m.
    """

    __slots__ = ("own", "radius")

    def __init__(self, own: OwnSet, radius: float) -> None:
        self.own, self.radius = own, radius


@final
class CoverGeometry:
    """Implements `protocol.kernel.robot.RobotGeometry`."""

    def inside(self, body: Cover, region: Region) -> bool:
        """Whether a body is in a region."""
        if region.is_everywhere:
            return True
        shape, own = region.shape.around, body.own
        return own.within(shape.x, shape.y, shape.radius - body.radius)

    def fits(self, body: Cover, line: Line, low: bool) -> bool:
        """Whether a body is on one side of a line."""
        return line.is_unit and body.own.satisfies(line.side(body.radius, low))

    def behind(self, place: Region, line: Line, low: bool) -> bool:
        """Whether a place is on one side of a line."""
        return is_beside(place.shape, line, low)

    def keeps(self, body: Cover, bound: Bound[Region, Line]) -> bool:
        """Whether a body is on the own side of everything that is obeyed of a binding."""
        return all(self.fits(body, line, bound.low) for line in bound.obeyed)


@final
class Bond:
    """One binding as the robot looks at it in every tick.

    Args:
        bound: the kernel's own end.
        own_radius: of the disk that keeps to it, m.
        radius: of the peer, m.

    Attributes:
        state: newest State heard of the peer.
        half_planes: where the own centre must stay.
        settled: whether one line is obeyed that was proposed, and nothing about it is open. Then
            nx, ny: its normal, away from this robot.
            offset: of the line along that, m.
            limit: of the own centre along that, m.
        transit: age of the peer's State when it could be used first, ticks.
        moved_x, moved_y: how far the peer came in a tick between the last two States of its, m.
        answers_left: States that still have to carry the answer.
    """

    __slots__ = (
        "answers_left",
        "bound",
        "half_planes",
        "limit",
        "moved_x",
        "moved_y",
        "nx",
        "ny",
        "offset",
        "own_radius",
        "owns",
        "peer",
        "radius",
        "settled",
        "state",
        "transit",
    )

    def __init__(self, bound: Bound[Region, Line], own_radius: float, radius: float) -> None:
        # What is looked at in every tick comes first, so that it lies together in memory.
        self.owns = bound.low
        self.settled = False
        self.answers_left = self.transit = 0
        self.state: PeerState | None = None
        self.nx = self.ny = self.limit = self.offset = 0.0
        self.moved_x = self.moved_y = 0.0
        self.radius, self.own_radius = radius, own_radius
        self.peer, self.bound = bound.peer, bound
        self.half_planes: tuple[HalfPlane, ...] = ()
        self.renew()

    def renew(self) -> None:
        """What is obeyed has changed."""
        bound = self.bound
        obeyed = bound.obeyed
        self.half_planes = tuple([line.side(self.own_radius, bound.low) for line in obeyed])
        lines = bound.lines
        self.settled = (
            bound.state == LINES
            and bound.place is None
            and len(obeyed) == 1
            and (not isinstance(lines, Owner) or lines.number > 0)
        )
        if self.settled:
            side = self.half_planes[0]
            self.nx, self.ny, self.limit = side.nx, side.ny, side.limit
            self.offset = obeyed[0].offset if self.owns else -obeyed[0].offset

    @property
    def is_asked(self) -> bool:
        """Whether the first line is still to be found."""
        return self.bound.state == ASKED

    def hear(self, state: PeerState, tick: int) -> None:
        """Take over a peer's State if it is newer."""
        known = self.state
        if known is not None and state.tick <= known.tick and state.incarnation == known.incarnation:
            return
        if known is None or known.incarnation != state.incarnation:
            self.moved_x = self.moved_y = 0.0
        elif state.placed and known.placed:
            ticks = state.tick - known.tick
            self.moved_x, self.moved_y = (state.x - known.x) / ticks, (state.y - known.y) / ticks
        self.state = state
        self.transit = tick + 1 - state.tick
        if self.bound.place is None:
            self.radius = state.radius

    def resize(self, own_radius: float) -> None:
        """This robot is another disk."""
        if own_radius != self.own_radius:
            self.own_radius = own_radius
            self.renew()
