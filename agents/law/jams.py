"""Jams: which robots back off for a while, so that others get through.

In passages that leave room for one only, two robots keep each other from their goals (`RightOfWay`): one goes
first; the others go back the way they came, to where they can be passed, and wait until those ahead have
passed, or for a while.

Where nothing is narrow (`Dispersal`), a crowd whose goals are on its far side presses itself together, and no
robot in it can move before another does. So all but one spread from the jam's centroid to twice the distance,
stand there a while, and go on one after the other. A robot at its goal steps aside in the same manner for one
that has been standing beside it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Final, final

from agents.law.deadlock import LAP, centroid, cluster
from agents.peers.state import PeerState
from protocol.geometry import Shape
from protocol.messages import Vector

# Laps:
JAM: Final = 16.0  # without coming nearer to the goal by a radius
TURN: Final = 64.0  # until another goes first
WAIT: Final = 24.0  # that the second in line backs off and stands
QUEUE: Final = 8.0  # that each after it waits longer where it is narrow,
QUEUE_WIDE: Final = 2.0  # and elsewhere
# Radii:
NEAR: Final = 2.0  # from its goal, within which a robot gets in no other's way to get there
ASIDE: Final = 3.0  # from an obstacle to the centre of a robot that another can pass there
APART: Final = 4.0  # from the others of the jam
STANDING: Final = 0.5  # by which a robot that stands moves at most while it is watched
CROWD: Final = 8  # robots, from which on a jam does not resolve itself
_CRUMBS: Final = 4096


class GivingWay:
    """One robot's part in jams; subclasses say what a jam is, and where to back off to.

    Args:
        robot: own id.
        radius: own, m.
        lap: time in which the largest disk moves by its radius at full speed, s.
        period: control period, s.
    """

    def __init__(self, robot: int, radius: float, lap: float, period: float) -> None:
        self._robot, self._radius = robot, radius
        self._lap = max(1, math.ceil(max(lap, 0.25 * LAP * period) / period))  # ticks
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

    def _back_off(self, tick: int, place: Vector, laps: float) -> None:
        self._back, self._until = place, tick + math.ceil(laps * self._lap)

    def _is_held(self, tick: int, left: float) -> bool:
        """Whether the robot, `left` m from its goal, has not come nearer for long; then the time is reset."""
        if left < self._nearest - self._radius:
            self._nearest, self._since = left, tick
        if tick - self._since < JAM * self._lap:
            return False
        self._since = tick
        return True

    def _wants(self, peer: PeerState) -> bool:
        """Whether a peer is still on its way to its goal."""
        return peer.placed and peer.gamma > (NEAR * self._radius) ** 2

    def _before(self, tick: int, jam: Iterable[PeerState]) -> list[PeerState]:
        """Those of these that go before this robot, by ids and the tick, which all of a jam know. After a
        while another robot is first, as the first may be the one that cannot move."""
        turn = int(tick // (TURN * self._lap))
        own = _order(self._robot, turn)
        return [peer for peer in jam if _order(peer.robot, turn) < own]


def _order(robot: int, turn: int) -> int:
    """A permutation of ids that is another one in every turn."""
    return (robot * 7919 + turn * 104_729 * robot) % 1_000_003


@final
class RightOfWay(GivingWay):
    """One robot's part in jams where obstacles leave little room."""

    def __init__(self, robot: int, radius: float, lap: float, period: float) -> None:
        super().__init__(robot, radius, lap, period)
        self._trail: list[Vector] = []
        self._awaited: dict[int, float] = {}  # peers that go first, and how far from their goals they were, m

    def look(
        self, tick: int, position: Vector, left: float, peers: Sequence[PeerState], obstacles: Sequence[Shape]
    ) -> None:
        """Update in a tick in which the robot may go on, at `position` and `left` m from its goal, among
        moving peers."""
        self._leave_trail(position)
        if not self._is_held(tick, left):
            return
        wanting = [peer for peer in peers if self._wants(peer)]
        before = self._before(tick, cluster(position, self._radius, wanting))
        if before:
            self._awaited = {peer.robot: math.sqrt(peer.gamma) for peer in before}
            self._back_off(tick, self._siding(position, peers, obstacles), WAIT + QUEUE * len(before))

    def let_pass(self, tick: int, position: Vector, peers: Sequence[PeerState]) -> None:
        """Go on from this tick if all moving peers that the robot gives way to have passed, or are at their
        goals."""
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

    def _siding(self, position: Vector, peers: Sequence[PeerState], obstacles: Sequence[Shape]) -> Vector:
        """The last place on the own way where the others can pass, or else its beginning, m."""
        near = (ASIDE + APART) * self._radius
        jam = [(p.x, p.y) for p in peers if p.placed and math.dist(position, (p.x, p.y)) < near + p.radius]
        for crumb in reversed(self._trail):
            wide = all(obstacle.distance(*crumb) >= ASIDE * self._radius for obstacle in obstacles)
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


@final
class Dispersal(GivingWay):
    """One robot's part in jams where nothing is narrow."""

    def __init__(self, robot: int, radius: float, lap: float, period: float) -> None:
        super().__init__(robot, radius, lap, period)
        self._beside: dict[int, Vector] = {}  # peers that wanted to pass, and where, at the last look, m

    def look(
        self, tick: int, position: Vector, left: float, peers: Sequence[PeerState], *, stuck: bool
    ) -> None:
        """As `RightOfWay.look`; `stuck`: whether the robot escapes from a deadlock."""
        if left <= NEAR * self._radius:
            self._look_beside(tick, position, peers)
            return
        self._beside = {}
        if not self._is_held(tick, left) or not stuck:
            return
        jam = _jam(position, self._radius, peers)
        if len(jam) + 1 < CROWD:
            return
        rank = len(self._before(tick, [peer for peer in jam if self._wants(peer)]))
        if rank > 0:
            self._back_off(tick, _spread(position, jam), WAIT + QUEUE_WIDE * rank)

    def _look_beside(self, tick: int, position: Vector, peers: Sequence[PeerState]) -> None:
        """At the goal: step aside if a peer on its way has stood beside this robot since the last look."""
        self._nearest = math.inf
        if tick - self._since < JAM * self._lap:
            return
        self._since = tick
        jam = _jam(position, self._radius, peers)
        before = self._beside
        self._beside = {peer.robot: (peer.x, peer.y) for peer in jam if self._wants(peer)}
        for robot, place in self._beside.items():
            if robot in before and math.dist(place, before[robot]) < STANDING * self._radius:
                self._back_off(tick, _spread(position, jam), WAIT)
                return


def _jam(position: Vector, radius: float, peers: Sequence[PeerState]) -> list[PeerState]:
    return cluster(position, radius, [peer for peer in peers if peer.placed])


def _spread(position: Vector, jam: Sequence[PeerState]) -> Vector:
    """Twice as far from the centroid of the robot and its jam, m."""
    x, y = centroid([*[(peer.x, peer.y) for peer in jam], position])
    return 2.0 * position[0] - x, 2.0 * position[1] - y
