"""Right of way: who backs off where things leave room for one only, and two want to go through.

No flow and no line resolves that: each keeps the other from its goal, and wants nothing else. So one goes
first and the others of the jam go back the way they came, to where they can be passed, and wait until those
who go before them have passed, or for a while.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final, final

from agents.laws.jams.giving_way import GivingWay
from agents.navigation.deadlock import cluster
from agents.peers.state import PeerState
from protocol.geometry import Shape
from protocol.messages import Vector

# Laps:
WAIT: Final = 24.0  # that the second in line goes back and stands
QUEUE: Final = 8.0  # that each after it waits longer
# Radii:
ASIDE: Final = 3.0  # from a thing to the centre of a robot that another can pass there
APART: Final = 4.0  # from the others of the jam
_CRUMBS: Final = 4096


@final
class RightOfWay(GivingWay):
    """One robot's part in jams where things leave little room."""

    def __init__(self, robot: int, radius: float, lap: float, period: float) -> None:
        """See `GivingWay`."""
        super().__init__(robot, radius, lap, period)
        self._trail: list[Vector] = []
        self._awaited: dict[int, float] = {}  # who goes first, and how far it was from its goal then, m

    def look(
        self, tick: int, position: Vector, left: float, peers: Sequence[PeerState], things: Sequence[Shape]
    ) -> None:
        """Take in a tick in which the robot may go on.

        Args:
            position: own, m.
            left: length of the way to the goal, m.
            peers: who moves.
            things: what stands.
        """
        self._leave_trail(position)
        if not self._is_held(tick, left):
            return
        wanting = [peer for peer in peers if self._wants(peer)]
        before = self._before(tick, cluster(position, self._radius, wanting))
        if before:
            self._awaited = {peer.robot: math.sqrt(peer.gamma) for peer in before}
            self._back_off(tick, self._siding(position, peers, things), WAIT + QUEUE * len(before))

    def let_pass(self, tick: int, position: Vector, peers: Sequence[PeerState]) -> None:
        """Take in a tick in which the robot may give way: if all that it gives way to have passed, or are
        at their goals, it goes on.

        Args:
            tick: present.
            position: own, m.
            peers: who moves.
        """
        if self._back is None:
            return
        for peer in peers:
            if peer.robot in self._awaited and not self._has_passed(position, peer):
                return
        self._until = tick

    def _has_passed(self, position: Vector, peer: PeerState) -> bool:
        """Whether a peer is at its goal, or well on its way to it, and away from this robot."""
        if not self._wants(peer):
            return peer.placed
        dx, dy = peer.x - position[0], peer.y - position[1]
        clear = math.hypot(dx, dy) > APART * self._radius + peer.radius
        on_its_way = self._awaited[peer.robot] - math.sqrt(peer.gamma) > APART * self._radius
        return clear and on_its_way and dx * peer.vx + dy * peer.vy > 0.0

    def _siding(self, position: Vector, peers: Sequence[PeerState], things: Sequence[Shape]) -> Vector:
        """The last place on the own way where the others can pass, or else its beginning, m."""
        near = (ASIDE + APART) * self._radius
        jam = [(p.x, p.y) for p in peers if p.placed and math.dist(position, (p.x, p.y)) < near + p.radius]
        for crumb in reversed(self._trail):
            wide = all(thing.distance(*crumb) >= ASIDE * self._radius for thing in things)
            if wide and all(math.dist(crumb, place) >= APART * self._radius for place in jam):
                return crumb
        return self._trail[0]

    def _leave_trail(self, position: Vector) -> None:
        """Remember the way, without its loops."""
        for index, crumb in enumerate(self._trail):
            if math.dist(position, crumb) < self._radius:
                del self._trail[index + 1 :]
                return
        if len(self._trail) < _CRUMBS:
            self._trail.append(position)
