"""Jams: robots that back off for a while, so that others get through.

In passages with room for one robot only, two robots block each other (`look_in_passages`): one goes first;
the others go back along their paths to a place where it can pass, and wait until it has passed, or for a
while.

In open space (`look_in_the_open`), a crowd whose goals are on its far side presses itself together, and no
robot can move before another does. So all but one spread from the jam's centroid to twice the distance,
pause, and continue one after the other. A robot at its goal moves aside likewise for one that stands beside
it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Final, final

from agents.law.deadlock import LAP, centroid, cluster
from agents.peers.state import PeerState
from protocol.geometry import Shape
from protocol.messages import Vector

# In laps:
JAM: Final = 16.0  # time without progress by a radius
TURN: Final = 64.0  # time until another robot goes first
WAIT: Final = 24.0  # time of backing off and standing of the second in line
QUEUE: Final = 8.0  # additional time of each further one in narrow passages,
QUEUE_WIDE: Final = 2.0  # and in open space
# In radii:
NEAR: Final = 2.0  # distance from its goal within which a robot blocks no others
ASIDE: Final = 3.0  # distance of a robot from an obstacle at which another can pass between
APART: Final = 4.0  # distance from the others of the jam
STANDING: Final = 0.5  # largest motion of a standing robot between two looks
CROWD: Final = 8  # robots from which a jam does not resolve itself
_CRUMBS: Final = 4096


@final
class GivingWay:
    """One robot's part in jams. `lap`: time in which the largest disk moves by its radius at full speed, s;
    `period`: of a tick, s."""

    def __init__(self, robot: int, radius: float, lap: float, period: float) -> None:
        self._robot, self._radius = robot, radius
        self._lap = max(1, math.ceil(max(lap, 0.25 * LAP * period) / period))  # ticks
        self._goal: Vector | None = None
        self._nearest, self._since = math.inf, 0
        self._back: Vector | None = None
        self._until = 0
        self._trail: list[Vector] = []
        self._awaited: dict[int, float] = {}  # peers that go first -> distance from their goals then, m
        self._beside: dict[int, Vector] = {}  # peers that wanted to pass -> position at the last look, m

    def yielding(self, tick: int, goal: Vector) -> Vector | None:
        """Place to back off to, m, while the robot gives way; None if it may continue to `goal` (m)."""
        if goal != self._goal:
            self._goal, self._back = goal, None
            self._nearest, self._since = math.inf, tick
        if self._back is not None and tick >= self._until:
            self._back, self._nearest, self._since = None, math.inf, tick
        return self._back

    def _back_off(self, tick: int, place: Vector, laps: float) -> None:
        self._back, self._until = place, tick + math.ceil(laps * self._lap)

    def _is_held(self, tick: int, left: float) -> bool:
        """Whether the robot, `left` m from its goal, has made no progress for long; resets the time if so."""
        if left < self._nearest - self._radius:
            self._nearest, self._since = left, tick
        if tick - self._since < JAM * self._lap:
            return False
        self._since = tick
        return True

    def _wants(self, peer: PeerState) -> bool:
        return peer.placed and peer.gamma > (NEAR * self._radius) ** 2

    def _before(self, tick: int, jam: Iterable[PeerState]) -> list[PeerState]:
        """Members of a jam that go before this robot, by ids and tick, which are common knowledge. The order
        changes after a while, since the first may be unable to move.
        """
        turn = int(tick // (TURN * self._lap))
        own = _order(self._robot, turn)
        return [peer for peer in jam if _order(peer.robot, turn) < own]

    # -- in narrow passages

    def look_in_passages(
        self, tick: int, position: Vector, left: float, peers: Sequence[PeerState], obstacles: Sequence[Shape]
    ) -> None:
        """Update in a tick in which the robot may continue, at `position` and `left` m from its goal, among
        moving peers.
        """
        self._leave_trail(position)
        if not self._is_held(tick, left):
            return
        wanting = [peer for peer in peers if self._wants(peer)]
        before = self._before(tick, cluster(position, self._radius, wanting))
        if before:
            self._awaited = {peer.robot: math.sqrt(peer.gamma) for peer in before}
            self._back_off(tick, self._siding(position, peers, obstacles), WAIT + QUEUE * len(before))

    def let_pass(self, tick: int, position: Vector, peers: Sequence[PeerState]) -> None:
        """Continue if all moving peers that the robot gives way to have passed, or are at their goals."""
        if self._back is None:
            return
        for peer in peers:
            if peer.robot in self._awaited and not self._has_passed(position, peer):
                return
        self._until = tick

    def _has_passed(self, position: Vector, peer: PeerState) -> bool:
        """Whether a peer is at its goal, or far on its way there, and moving away from this robot."""
        if not self._wants(peer):
            return peer.placed
        dx, dy = peer.x - position[0], peer.y - position[1]
        clear = math.hypot(dx, dy) > APART * self._radius + peer.radius
        on_its_way = self._awaited[peer.robot] - math.sqrt(peer.gamma) > APART * self._radius
        return clear and on_its_way and dx * peer.vx + dy * peer.vy > 0.0

    def _siding(self, position: Vector, peers: Sequence[PeerState], obstacles: Sequence[Shape]) -> Vector:
        """The last place of the own path where the others can pass; otherwise its beginning, m."""
        near = (ASIDE + APART) * self._radius
        jam = [(p.x, p.y) for p in peers if p.placed and math.dist(position, (p.x, p.y)) < near + p.radius]
        for crumb in reversed(self._trail):
            wide = all(obstacle.distance(*crumb) >= ASIDE * self._radius for obstacle in obstacles)
            if wide and all(math.dist(crumb, place) >= APART * self._radius for place in jam):
                return crumb
        return self._trail[0]

    def _leave_trail(self, position: Vector) -> None:
        for index, (x, y) in enumerate(self._trail):
            dx, dy = position[0] - x, position[1] - y
            if dx * dx + dy * dy < self._radius * self._radius:
                del self._trail[index + 1 :]
                return
        if len(self._trail) < _CRUMBS:
            self._trail.append(position)

    # -- in open space

    def look_in_the_open(
        self, tick: int, position: Vector, left: float, peers: Sequence[PeerState], *, stuck: bool
    ) -> None:
        """As `look_in_passages`; `stuck`: whether the robot escapes from a deadlock."""
        if left <= NEAR * self._radius:
            self._look_beside(tick, position, peers)
            return
        if not self._is_held(tick, left) or not stuck:
            return
        jam = _jam(position, self._radius, peers)
        if len(jam) + 1 < CROWD:
            return
        rank = len(self._before(tick, [peer for peer in jam if self._wants(peer)]))
        if rank > 0:
            self._back_off(tick, _spread(position, jam), WAIT + QUEUE_WIDE * rank)

    def _look_beside(self, tick: int, position: Vector, peers: Sequence[PeerState]) -> None:
        """At the goal: move aside if a peer on its way has stood beside this robot since the last look."""
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


def _order(robot: int, turn: int) -> int:
    """A permutation of ids that differs from turn to turn."""
    return (robot * 7919 + turn * 104_729 * robot) % 1_000_003


def _jam(position: Vector, radius: float, peers: Sequence[PeerState]) -> list[PeerState]:
    return cluster(position, radius, [peer for peer in peers if peer.placed])


def _spread(position: Vector, jam: Sequence[PeerState]) -> Vector:
    """Point twice as far from the centroid of the robot and its jam, m."""
    x, y = centroid([*[(peer.x, peer.y) for peer in jam], position])
    return 2.0 * position[0] - x, 2.0 * position[1] - y
