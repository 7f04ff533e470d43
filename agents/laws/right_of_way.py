"""Right of way: who backs off where things leave room for one only, and two want to go through.

No flow and no line resolves that: each keeps the other from its goal, and wants nothing else. So one goes
first and the others of the jam go back the way they came, to where they can be passed, and wait a while. Who
goes first follows from ids and the tick, so all of a jam know it without a word; it is somebody else after a
while, for whoever goes first may be the one that cannot.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

from agents.navigation.deadlock import LAP, cluster
from agents.peers.state import PeerState
from protocol.geometry import Shape

Vector = tuple[float, float]

# Laps: in one the largest disk moves by its radius at full speed.
JAM: Final = 16.0  # without coming nearer to the goal by a radius
WAIT: Final = 24.0  # that the second in line goes back and stands
QUEUE: Final = 8.0  # that each after it waits longer
TURN: Final = 64.0  # until somebody else goes first
# Radii:
ASIDE: Final = 3.0  # from a thing to the centre of a robot that another can pass there
APART: Final = 4.0  # from the others of the jam
_CRUMBS: Final = 4096


class RightOfWay:
    """One robot's part in jams.

    Args:
        robot: its id.
        radius: its own, m.
        lap: time in which the largest disk moves by its radius at full speed, s.
        period: control period, s.
    """

    def __init__(self, robot: int, radius: float, lap: float, period: float) -> None:
        self._robot, self._radius = robot, radius
        self._lap = max(1, math.ceil(max(lap, 0.25 * LAP * period) / period))  # ticks
        self._trail: list[Vector] = []
        self._goal: Vector | None = None
        self._nearest, self._since = math.inf, 0
        self._back: Vector | None = None
        self._until = 0

    def yielding(self, tick: int, goal: Vector) -> Vector | None:
        """Where the robot backs off to, m, while it gives way; None when it may go on to `goal` (m)."""
        if goal != self._goal:
            self._goal, self._back = goal, None
            self._nearest, self._since = math.inf, tick
        if self._back is not None and tick >= self._until:
            self._back, self._nearest, self._since = None, math.inf, tick
        return self._back

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
        if left < self._nearest - self._radius:
            self._nearest, self._since = left, tick
        if tick - self._since < JAM * self._lap:
            return
        self._since = tick
        rank = self._rank(tick, position, peers)
        if rank > 0:
            self._back = self._siding(position, peers, things)
            self._until = tick + math.ceil((WAIT + QUEUE * rank) * self._lap)

    def _rank(self, tick: int, position: Vector, peers: Sequence[PeerState]) -> int:
        """How many of the jam go before this robot; 0, too, if there is no jam."""
        turn = int(tick // (TURN * self._lap))
        wanting = [peer for peer in peers if peer.placed and peer.gamma > (2.0 * self._radius) ** 2]
        jam = {id(peer) for peer in cluster(position, self._radius, wanting)}
        own = _order(self._robot, turn)
        return sum(_order(peer.robot, turn) < own for peer in wanting if id(peer) in jam)

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


def _order(robot: int, turn: int) -> int:
    """A permutation of ids that is another one in every turn."""
    return (robot * 7919 + turn * 104_729 * robot) % 1_000_003
