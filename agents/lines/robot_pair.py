"""One pair as one robot sees it: own end of the line, peer as last heard, disk that it may have left."""

from __future__ import annotations

import math
from typing import Final, final

from agents.lines.ends import Follower, Owner
from agents.lines.line import HalfPlane, Line
from agents.lines.tangent import Tangent
from agents.peers.state import PeerState
from protocol.geometry import Disk
from protocol.messages import Member

_ROOM: Final = 0.25  # of the smaller radius, beyond both error bounds: a late line must still find room


@final
class RobotPair:
    """What binds this robot to one peer.

    Args:
        peer: its id.
        incarnation: own incarnation.
        owns: whether this robot has the lower id.
        own_radius, radius: of this robot and of the peer, m.
        initial: the line obeyed since the start, if both can know one.
        peer_incarnation: the peer's incarnation that begins with it, its first in this run.

    Attributes:
        end: this robot's end of the line.
        state: newest State heard of the peer's present incarnation.
        disk: the peer's, while it stands, or is kept free for it to appear.
        excused: whether the peer's disk is not in the workspace, as far as is known.
        line_half_planes: where the own centre must stay because of the lines obeyed.
        settled: whether both obey one and the same line, and nothing about it is open. Then
            nx, ny: its normal, away from this robot.
            offset: of the line along that, m.
            limit: of the own centre along that, m.
        rests: whether the line is looked at together with others (`InitialLines`).
        transit: age of the peer's State when it could be used first, ticks.
        moved_x, moved_y: how far the peer came in a tick between the last two States of its, m.
        answers_left: States that still have to carry the answer.
    """

    __slots__ = (
        "answers_left",
        "disk",
        "end",
        "excused",
        "heard",
        "limit",
        "line_half_planes",
        "moved_x",
        "moved_y",
        "nx",
        "ny",
        "offset",
        "own_radius",
        "owns",
        "peer",
        "radius",
        "rests",
        "settled",
        "state",
        "transit",
    )

    def __init__(
        self,
        peer: int,
        incarnation: int,
        *,
        owns: bool,
        own_radius: float,
        radius: float,
        initial: Line | None,
        peer_incarnation: int = 0,
    ) -> None:
        # What is looked at in every tick comes first, so that it lies together in memory.
        self.owns = owns
        self.settled = self.excused = self.rests = False
        self.heard = 0  # newest incarnation of the peer that was heard
        self.answers_left = self.transit = 0
        self.state: PeerState | None = None
        self.nx = self.ny = self.limit = self.offset = 0.0
        self.moved_x = self.moved_y = 0.0
        self.radius, self.own_radius = radius, own_radius
        self.peer = peer
        self.end: Owner | Follower = (Owner if owns else Follower)(incarnation, initial, peer_incarnation)
        self.disk: Tangent | None = None
        self.line_half_planes: tuple[HalfPlane, ...] = ()
        self.renew()

    @property
    def ready(self) -> bool:
        """Whether the peer is surely behind something that this robot obeys, or not there."""
        return self.excused or self.end.agreed or self.keeps_clear

    @property
    def keeps_clear(self) -> bool:
        """Whether this robot keeps to a half-plane between it and the peer's standing disk."""
        return self.disk is not None and self.disk.half_plane is not None

    @property
    def half_planes(self) -> tuple[HalfPlane, ...]:
        """Where the own centre must stay because of this peer, lines or disk."""
        if self.disk is None or self.disk.half_plane is None:
            return self.line_half_planes
        return (*self.line_half_planes, self.disk.half_plane)

    @property
    def quiet(self) -> bool:
        """Whether both obey one and the same line, be it the initial one, and the peer says nothing, nor is
        anything to be said to it."""
        if self.state is not None or self.disk is not None or self.answers_left:
            return False
        return self.end.agreed and self.end.linked and len(self.line_half_planes) == 1

    def crowding(self, x: float, y: float, bound: float) -> tuple[float, float]:
        """How far to back off, m, so that a line fits between this robot and a peer's new incarnation, or its
        disk can appear; to be asked while there is no line.

        A line needs room for both error bounds. An incarnation that has just begun may know its place less
        well than the one before it, and cannot move until it has a line with everybody.

        Args:
            x, y, bound: own position, m, and its error bound, m.
        """
        state, room = self.state, _ROOM * min(self.own_radius, self.radius)
        if state is None or not state.placed:
            if self.disk is None or self.disk.half_plane is not None:
                return 0.0, 0.0
            return self.disk.lacking(x, y, bound + room)
        dx, dy = x - state.x, y - state.y
        distance = math.hypot(dx, dy)
        lacking = self.own_radius + self.radius + bound + state.bound - distance + room
        if lacking <= 0.0:
            return 0.0, 0.0
        if distance == 0.0:
            return lacking, 0.0
        return lacking * dx / distance, lacking * dy / distance

    def accept(self, state: PeerState) -> bool:
        """Take over a peer's State if it is newer; False when it is of an old incarnation, to be ignored."""
        known = self.state
        if known is None or state.incarnation != known.incarnation:
            if not self.end.accept(state.incarnation):
                return False
            self.heard = state.incarnation
            self.excused = False
            self.state = state
            self.moved_x = self.moved_y = 0.0
            self.renew()
        elif state.tick > known.tick:
            if state.placed and known.placed:
                ticks = state.tick - known.tick
                self.moved_x, self.moved_y = (state.x - known.x) / ticks, (state.y - known.y) / ticks
            self.state = state
        return True

    def renew(self) -> None:
        """What is obeyed has changed."""
        obeyed = self.end.obeyed
        self.line_half_planes = tuple([line.side(self.own_radius, self.owns) for line in obeyed])
        if self.end.agreed:
            self.disk = None
        self.settled = self.end.settled and self.disk is None
        if self.settled:
            side = self.line_half_planes[0]
            self.nx, self.ny, self.limit = side.nx, side.ny, side.limit
            self.offset = obeyed[0].offset if self.owns else -obeyed[0].offset

    def resize(self, own_radius: float) -> None:
        """This robot is another disk."""
        self.own_radius = own_radius
        if self.disk is not None:
            self.disk.resize(own_radius)
        self.renew()

    def on_member(self, member: Member) -> None:
        """A newer roster says something else of the peer than the one before."""
        if member.incarnation < self.heard:
            return  # whoever was heard since is there, and nothing of an older incarnation excuses it
        if member.status == "live":
            self._expect(member.incarnation)
        elif member.status == "gone":
            self._release(member.incarnation)
        else:
            self._stand(member)

    def _expect(self, incarnation: int) -> None:
        """The peer lives, in this incarnation or in a newer one; what older ones say does not count."""
        self.excused = False
        if incarnation > self.end.peer_incarnation:
            self.end.expect(incarnation)
            self.state = None
            self.renew()

    def _stand(self, member: Member) -> None:
        """The peer's disk stands at a place, or is to appear there; nothing is there yet if this robot is in
        its way, so that it may move away."""
        assert member.position is not None
        self.radius = member.radius
        radius = member.radius + member.bound
        self.disk = Tangent(Disk(*member.position, radius), self.own_radius, self.half_planes)
        self.excused = member.status == "appearing"
        self._end(member.incarnation)

    def _release(self, incarnation: int) -> None:
        """The peer's disk is not in the workspace any more."""
        self.disk = None
        self.excused = True
        self._end(incarnation)

    def _end(self, incarnation: int) -> None:
        """No incarnation up to this one moves again: its disk, or nothing, replaces all lines."""
        self.end.fence(incarnation)
        self.state = None
        self.renew()
